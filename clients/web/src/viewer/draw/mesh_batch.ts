// All meshes of one appearance, plates included, whatever their triangles: one draw call.
import { BatchedMesh, Mesh, type BufferGeometry, type Color, type Intersection, type Matrix4, type Raycaster } from "three";
import type { Batch, Hit, Slot } from "./batch";
import { materialFor, type Appearance } from "./appearance";

const firstInstances = 16;
const firstVertices = 4096;

interface StoredMesh { id: number; users: number; geometry: BufferGeometry; }

interface MeshSlot<Owner> extends Slot<Owner> { readonly key: string; }

export class MeshBatch<Owner> implements Batch<Owner> {
  readonly object: BatchedMesh;
  private readonly held = new Map<string, StoredMesh>();
  private readonly slots = new Map<number, MeshSlot<Owner>>();

  constructor(appearance: Appearance) {
    this.object = new BatchedMesh(firstInstances, firstVertices, 3 * firstVertices, materialFor(appearance, true));
    this.object.frustumCulled = false;
    this.object.perObjectFrustumCulled = false;  // drawing all costs less than testing each
    this.object.sortObjects = false;
    this.object.matrixAutoUpdate = false;
  }

  get count(): number { return this.slots.size; }

  holds(key: string): boolean { return this.held.has(key); }

  // Geometries of one key are the same; they have positions, normals and an index.
  add(owner: Owner, key: string, geometry: BufferGeometry, matrix: Matrix4, color: Color): Slot<Owner> {
    const held = this.hold(key, geometry);
    if (this.slots.size === this.object.maxInstanceCount) this.object.setInstanceCount(2 * this.object.maxInstanceCount);
    const slot: MeshSlot<Owner> = { owner, key, index: this.object.addInstance(held.id) };
    this.slots.set(slot.index, slot);
    this.setMatrix(slot, matrix);
    this.setColor(slot, color);
    return slot;
  }

  setMatrix(slot: Slot<Owner>, matrix: Matrix4): void { this.object.setMatrixAt(slot.index, matrix); }

  setColor(slot: Slot<Owner>, color: Color): void { this.object.setColorAt(slot.index, color); }

  remove(slot: Slot<Owner>): void {
    const own = this.slots.get(slot.index);
    if (!own || !this.slots.delete(slot.index)) return;
    this.object.deleteInstance(slot.index);
    const held = this.held.get(own.key);
    if (!held || --held.users > 0) return;
    this.object.deleteGeometry(held.id);
    this.held.delete(own.key);
  }

  hits(raycaster: Raycaster): Hit<Owner>[] {
    const found: Hit<Owner>[] = [];
    for (const { owner, key, index } of this.slots.values()) {
      const held = this.held.get(key);
      if (!held) continue;
      const mesh = new Mesh(held.geometry, this.object.material);
      this.object.getMatrixAt(index, mesh.matrixWorld);
      const met: Intersection[] = [];
      mesh.raycast(raycaster, met);
      for (const { distance } of met) found.push({ owner, distance });
    }
    return found;
  }

  private hold(key: string, geometry: BufferGeometry): StoredMesh {
    const known = this.held.get(key);
    if (known) {
      ++known.users;
      return known;
    }
    this.makeRoom(geometry);
    const held = { id: this.object.addGeometry(geometry), users: 1, geometry };
    this.held.set(key, held);
    return held;
  }

  // First reuses the room of removed geometries, then allocates twice as much as is needed.
  private makeRoom(geometry: BufferGeometry): void {
    const vertices = geometry.getAttribute("position").count;
    const indices = geometry.index?.count ?? 0;
    const fits = (): boolean => this.object.unusedVertexCount >= vertices && this.object.unusedIndexCount >= indices;
    if (fits()) return;
    this.object.optimize();  // where nothing is left too: what is gone counts as used until then
    if (fits()) return;
    let usedVertices = 0;
    let usedIndices = 0;
    for (const { geometry: other } of this.held.values()) {
      usedVertices += other.getAttribute("position").count;
      usedIndices += other.index?.count ?? 0;
    }
    this.object.setGeometrySize(Math.max(firstVertices, 2 * (usedVertices + vertices)),
                                Math.max(3 * firstVertices, 2 * (usedIndices + indices)));
  }
}
