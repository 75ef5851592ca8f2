// Blobs read from the server by hash and cached by the browser: meshes, points, labels.
import { BufferAttribute, BufferGeometry } from "three";
import { TransientError, withRetries } from "../retry";

// Above these limits unused blobs are dropped; the browser has them in its cache.
const maxKept = 500;
const maxKept_bytes = 256 << 20;

// The server, or a proxy on its behalf, is temporarily out of resources.
const transientStatuses = new Set([408, 429, 502, 503, 504]);

async function fetchOnce(hash: string): Promise<ArrayBuffer> {
  const path = `/geometry/${encodeURIComponent(hash)}`;
  let response: Response;
  try {
    response = await fetch(path);
    if (response.ok) return await response.arrayBuffer();
  } catch (error) {  // of the network; the page says itself that it is gone
    throw new TransientError(`${path}: ${String(error)}`);
  }
  const why = `${path}: ${response.status}`;
  throw transientStatuses.has(response.status) ? new TransientError(why) : new Error(why);
}

// Repeats a fetch while it is wanted and the failure may be temporary.
export const fetchBlob = (hash: string, isWanted: () => boolean): Promise<ArrayBuffer> =>
  withRetries(() => fetchOnce(hash), isWanted);

// MESH_F64 of world.proto. Throws when the bytes are not a mesh.
export function meshOf(bytes: ArrayBuffer): BufferGeometry {
  const [vertices = 0, triangles = 0] = bytes.byteLength >= 8 ? new Uint32Array(bytes, 0, 2) : [];
  const expected = 8 + 24 * vertices + 12 * triangles;
  if (bytes.byteLength !== expected) throw new Error(`mesh: ${bytes.byteLength} bytes, must be ${expected}`);
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(new Float64Array(bytes, 8, 3 * vertices)), 3));
  geometry.setIndex(new BufferAttribute(new Uint32Array(bytes.slice(8 + 24 * vertices)), 1));
  geometry.computeVertexNormals();
  geometry.computeBoundingSphere();
  geometry.computeBoundingBox();
  return geometry;
}

const bytesOf = (geometry: BufferGeometry): number =>
  24 * geometry.getAttribute("position").count + 4 * (geometry.index?.count ?? 0);  // with normals

interface PendingMesh { mesh: Promise<BufferGeometry | undefined>; wanted: (() => boolean)[]; }

export class MeshLibrary {
  private readonly known = new Map<string, BufferGeometry>();  // the ones that came first are first
  private readonly pending = new Map<string, PendingMesh>();
  private bytes = 0;

  constructor(private readonly failed: (why: string) => void, private readonly fetchOf: typeof fetchBlob = fetchBlob) {}

  get size(): number { return this.known.size; }

  // Drops the oldest unused blobs until the rest is within the limits.
  trim(isUsed: (hash: string) => boolean): void {
    for (const [hash, geometry] of this.known) {
      if (this.known.size <= maxKept && this.bytes <= maxKept_bytes) return;
      if (isUsed(hash)) continue;
      geometry.dispose();
      this.known.delete(hash);
      this.bytes -= bytesOf(geometry);
    }
  }

  // The geometry if it has been received.
  now(hash: string): BufferGeometry | undefined { return this.known.get(hash); }

  // Undefined if it is not available, which is reported once, or if it is no longer wanted.
  get(hash: string, isWanted: () => boolean): Promise<BufferGeometry | undefined> {
    const known = this.known.get(hash);
    if (known) return Promise.resolve(known);
    let pendingMesh = this.pending.get(hash);
    if (pendingMesh) pendingMesh.wanted.push(isWanted);
    else {
      const wanted = [isWanted];
      pendingMesh = { wanted, mesh: this.fetch(hash, wanted).finally(() => this.pending.delete(hash)) };
      this.pending.set(hash, pendingMesh);
    }
    return pendingMesh.mesh;
  }

  private async fetch(hash: string, wanted: readonly (() => boolean)[]): Promise<BufferGeometry | undefined> {
    try {
      const geometry = meshOf(await this.fetchOf(hash, () => wanted.some((isWanted) => isWanted())));
      this.known.set(hash, geometry);
      this.bytes += bytesOf(geometry);
      return geometry;
    } catch (error) {
      if (!(error instanceof TransientError)) this.failed(error instanceof Error ? error.message : String(error));
      return undefined;
    }
  }
}
