// Blobs by hash from the server, which the browser keeps for ever: meshes, points, labels.
import { BufferAttribute, BufferGeometry } from "three";

const attempts = 3;
const pause_ms = 400;

const mostKept = 500;

export async function fetchBlob(hash: string): Promise<ArrayBuffer> {
  for (let attempt = 1; ; ++attempt) {
    try {
      const response = await fetch(`/geometry/${encodeURIComponent(hash)}`);
      if (!response.ok) throw new Error(`/geometry/${hash}: ${response.status}`);
      return await response.arrayBuffer();
    } catch (error) {
      if (attempt === attempts) throw error;
      await new Promise((resolve) => setTimeout(resolve, pause_ms * attempt));
    }
  }
}

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

export class MeshLibrary {
  private readonly known = new Map<string, BufferGeometry>();
  private readonly onTheWay = new Map<string, Promise<BufferGeometry | undefined>>();

  constructor(private readonly failed: (why: string) => void) {}

  // Of those that nobody uses, the ones beyond what is worth keeping: they are in the browser's cache, too.
  trim(isUsed: (hash: string) => boolean): void {
    if (this.known.size <= mostKept) return;
    for (const [hash, geometry] of this.known) {
      if (isUsed(hash)) continue;
      geometry.dispose();
      this.known.delete(hash);
      this.onTheWay.delete(hash);
    }
  }

  // What has arrived.
  now(hash: string): BufferGeometry | undefined { return this.known.get(hash); }

  // Undefined where it cannot be had, which is told once.
  get(hash: string): Promise<BufferGeometry | undefined> {
    let coming = this.onTheWay.get(hash);
    if (!coming) {
      coming = fetchBlob(hash).then((bytes) => {
        const geometry = meshOf(bytes);
        this.known.set(hash, geometry);
        return geometry;
      }).catch((error: unknown) => {
        this.failed(error instanceof Error ? error.message : String(error));
        this.onTheWay.delete(hash);
        return undefined;
      });
      this.onTheWay.set(hash, coming);
    }
    return coming;
  }
}
