// Meshes by hash, decoded once and shared by every picture.
import { BufferAttribute, BufferGeometry } from "three";
import type { MeshSource } from "./shape_geometry";

// Little-endian numbers as base64: x y z of each vertex as float32, three corners of each triangle
// as uint32.
export interface PackedMesh { vertices: string; triangles: string; }

export function bytesOf(base64: string): ArrayBuffer {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes.buffer;
}

export function meshGeometry(mesh: PackedMesh): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(bytesOf(mesh.vertices)), 3));
  geometry.setIndex(new BufferAttribute(new Uint32Array(bytesOf(mesh.triangles)), 1));
  geometry.computeVertexNormals();
  return geometry;
}

// A missing hash gives an empty geometry: the page shows what it has.
export function meshSource(meshes: Record<string, PackedMesh>): MeshSource {
  const decoded = new Map<string, BufferGeometry>();
  return (hash) => {
    let geometry = decoded.get(hash);
    if (geometry === undefined) {
      geometry = meshGeometry(meshes[hash] ?? { vertices: "", triangles: "" });
      decoded.set(hash, geometry);
    }
    return geometry;
  };
}
