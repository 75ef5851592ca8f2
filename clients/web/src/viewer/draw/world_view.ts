// The objects of a world as instances of a few batches, kept in step with them: unchanged objects
// are not touched.
import { Box3, BufferGeometry, Color, Group, Matrix4, Vector3, type Raycaster } from "three";
import { plateGeometry } from "../../scene/shape_geometry";
import type { Plate } from "../../world/types";
import type { Batch, Hit, Slot } from "./batch";
import type { MeshLibrary } from "./blobs";
import type { Appearance } from "./appearance";
import { MeshBatch } from "./mesh_batch";
import type { Layer, Part } from "./parts";
import { ShapeBatch, type Unit } from "./shape_batch";

// A named object that is drawn. A change gives a new value; `shape` tells whether its parts are
// unchanged.
export interface DrawnObject {
  name: string;
  color: string;
  shape: string;
  frames: readonly Matrix4[];  // poses of its parts in the world
  parts: readonly { frame: number; part: Part }[];
}

interface Placed { drawnObject: Drawn; frame: number; part: Part; batch: Batch<Placed>; slot: Slot<Placed>; }

interface Drawn { value: DrawnObject; placed: Placed[]; isGone: boolean; }

// The order of drawing: translucent appearances come last.
const renderOrder: Record<Appearance, number> = { solid: 0, stale: 0, completed: 1, mover: 2, unseen: 3, ghost: 4 };

// The distance by which what one sees through is put behind everything else when it is pointed at.
const seenThrough: Partial<Record<Appearance, number>> = { ghost: 1e3, mover: 1e3, unseen: 2e6 };

// The triangles of one of a plate's two groups.
function plateFace(plate: Plate, face: "top" | "rest"): BufferGeometry {
  const whole = plateGeometry(plate);
  const group = whole.groups[face === "top" ? 0 : 1];
  const index = whole.index;
  whole.deleteAttribute("uv");
  if (group && index) whole.setIndex([...index.array.slice(group.start, group.start + group.count)]);
  whole.clearGroups();
  return whole;
}

export class WorldView {
  readonly root = new Group();
  private readonly drawn = new Map<string, Drawn>();
  private readonly shapes = new Map<string, ShapeBatch<Placed>>();
  private readonly meshes = new Map<Appearance, MeshBatch<Placed>>();
  private hidden: ReadonlySet<Layer> = new Set();

  // The usual batches exist from the first picture on, so that their shaders are compiled when
  // objects come.
  constructor(private readonly library: MeshLibrary, private readonly changed: () => void) {
    for (const unit of ["box", "shaft", "capsule"] as const) this.shapeBatch(unit, "solid");
  }

  sync(drawnObjects: ReadonlyMap<string, DrawnObject>): void {
    this.follow(drawnObjects);
    this.trim();
  }

  private follow(drawnObjects: ReadonlyMap<string, DrawnObject>): void {
    for (const [name, drawn] of this.drawn) {
      if (!drawnObjects.has(name)) this.remove(name, drawn);
    }
    for (const drawnObject of drawnObjects.values()) {
      const drawn = this.drawn.get(drawnObject.name);
      if (drawn?.value === drawnObject) continue;
      if (drawn && drawn.value.shape === drawnObject.shape) this.update(drawn, drawnObject);
      else {
        if (drawn) this.remove(drawnObject.name, drawn);
        this.add(drawnObject);
      }
    }
  }

  // Drops meshes that no instance uses.
  private trim(): void { this.library.trim((hash) => [...this.meshes.values()].some((batch) => batch.holds(hash))); }

  // Draws all objects again without these layers.
  hideLayers(hidden: ReadonlySet<Layer>): void {
    const drawnObjects = new Map([...this.drawn].map(([name, { value }]) => [name, value]));
    this.follow(new Map());  // and keeps all meshes
    this.hidden = hidden;
    this.sync(drawnObjects);
  }

  // The name of the first object that the ray hits. Completed parts can be picked like measured
  // ones; query bodies, movers and unseen space only if nothing else is hit.
  pick(raycaster: Raycaster): Hit<string> | undefined {
    let nearest: Hit<string> | undefined;
    for (const batch of [...this.shapes.values(), ...this.meshes.values()]) {
      for (const { owner, distance } of batch.hits(raycaster)) {
        const behind = seenThrough[owner.part.appearance] ?? 0;
        if (distance + behind < (nearest?.distance ?? Infinity)) nearest = { owner: owner.drawnObject.value.name, distance: distance + behind };
      }
    }
    return nearest;
  }

  get instanceCount(): number {
    return [...this.shapes.values(), ...this.meshes.values()].reduce((sum, batch) => sum + batch.count, 0);
  }

  // The bounds of an object's drawn parts. Empty if nothing is drawn, or nothing yet.
  boundsOf(name: string): Box3 {
    const bounds = new Box3();
    for (const { part, frame, drawnObject } of this.drawn.get(name)?.placed ?? []) {
      const X = new Matrix4().multiplyMatrices(drawnObject.value.frames[frame] ?? new Matrix4(), part.local);
      bounds.union(this.partBox(part).applyMatrix4(X));
    }
    return bounds;
  }

  // The bounds of an object's parts in a frame of it, in that frame; as above.
  frameBounds({ parts }: DrawnObject, frame: number): Box3 {
    const bounds = new Box3();
    for (const one of parts) {
      if (one.frame === frame) bounds.union(this.partBox(one.part).applyMatrix4(one.part.local));
    }
    return bounds;
  }

  private partBox(part: Part): Box3 {
    const { geometry } = part;
    if (geometry.is === "unit") {
      const wide = geometry.unit === "box" ? 0.5 : 1;
      const high = geometry.unit === "capsule" ? 1 + geometry.form[0] : 0.5;
      return new Box3(new Vector3(-wide, -wide, -high), new Vector3(wide, wide, high));
    }
    if (geometry.is === "mesh") return this.library.now(geometry.hash)?.boundingBox?.clone() ?? new Box3();
    const { outline, thickness_m } = geometry.plate;
    const box = new Box3();
    for (const { x, y } of outline.vertices) box.expandByPoint(new Vector3(x, y, 0)).expandByPoint(new Vector3(x, y, -thickness_m));
    return box;
  }

  private add(value: DrawnObject): void {
    const drawn: Drawn = { value, placed: [], isGone: false };
    this.drawn.set(value.name, drawn);
    for (const { frame, part } of value.parts) {
      if (!this.hidden.has(part.layer)) this.place(drawn, frame, part);
    }
  }

  private place(drawn: Drawn, frame: number, part: Part): void {
    const { geometry } = part;
    if (geometry.is === "unit") this.placeUnit(drawn, frame, part, geometry.unit, geometry.form);
    else if (geometry.is === "plate") {
      const key = JSON.stringify([geometry.face, geometry.plate]);
      this.placeMesh(drawn, frame, part, key, plateFace(geometry.plate, geometry.face));
    } else {
      const known = this.library.now(geometry.hash);
      if (known) this.placeMesh(drawn, frame, part, geometry.hash, known);
      else void this.placeLater(drawn, frame, part, geometry.hash);
    }
  }

  private async placeLater(drawn: Drawn, frame: number, part: Part, hash: string): Promise<void> {
    const mesh = await this.library.get(hash, () => !drawn.isGone);
    if (!mesh || drawn.isGone) return;
    this.placeMesh(drawn, frame, part, hash, mesh);
    this.changed();
  }

  private placeUnit(drawn: Drawn, frame: number, part: Part, unit: Unit, form: readonly [number, number]): void {
    const batch = this.shapeBatch(unit, part.appearance);
    this.put(drawn, frame, part, batch, (placed) => batch.add(placed, this.matrixOf(placed), new Color(drawn.value.color), form));
  }

  private placeMesh(drawn: Drawn, frame: number, part: Part, key: string, geometry: BufferGeometry): void {
    if ((geometry.index?.count ?? 0) === 0) return;
    const batch = this.meshBatch(part.appearance);
    this.put(drawn, frame, part, batch, (placed) => batch.add(placed, key, geometry, this.matrixOf(placed), new Color(drawn.value.color)));
  }

  private put(drawnObject: Drawn, frame: number, part: Part, batch: Batch<Placed>, add: (placed: Placed) => Slot<Placed>): void {
    const placed = { drawnObject, frame, part, batch } as Placed;
    placed.slot = add(placed);
    drawnObject.placed.push(placed);
  }

  private readonly matrix = new Matrix4();
  private matrixOf({ drawnObject, frame, part }: Placed): Matrix4 {
    return this.matrix.multiplyMatrices(drawnObject.value.frames[frame] ?? this.matrix.identity(), part.local);
  }

  private update(drawn: Drawn, value: DrawnObject): void {
    const isRecolored = drawn.value.color !== value.color;
    drawn.value = value;
    const color = new Color(value.color);
    for (const placed of drawn.placed) {
      placed.batch.setMatrix(placed.slot, this.matrixOf(placed));
      if (isRecolored) placed.batch.setColor(placed.slot, color);
    }
  }

  private remove(name: string, drawn: Drawn): void {
    drawn.isGone = true;
    for (const { batch, slot } of drawn.placed) batch.remove(slot);
    this.drawn.delete(name);
  }

  private shapeBatch(unit: Unit, appearance: Appearance): ShapeBatch<Placed> {
    const key = `${unit} ${appearance}`;
    let batch = this.shapes.get(key);
    if (!batch) {
      batch = new ShapeBatch<Placed>(unit, appearance, (before, now) => this.root.remove(before).add(now));
      batch.object.renderOrder = renderOrder[appearance];
      this.shapes.set(key, batch);
      this.root.add(batch.object);
    }
    return batch;
  }

  private meshBatch(appearance: Appearance): MeshBatch<Placed> {
    let batch = this.meshes.get(appearance);
    if (!batch) {
      batch = new MeshBatch<Placed>(appearance);
      batch.object.renderOrder = renderOrder[appearance];
      this.meshes.set(appearance, batch);
      this.root.add(batch.object);
    }
    return batch;
  }
}
