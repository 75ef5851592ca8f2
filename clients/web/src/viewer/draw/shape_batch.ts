// All boxes, all cylinders and cones, or all spheres and capsules of one appearance: one unit geometry,
// one draw call.
import {
  BoxGeometry, BufferGeometry, CapsuleGeometry, CylinderGeometry, DynamicDrawUsage, InstancedBufferAttribute, InstancedMesh,
  Matrix4, Mesh, Sphere, Vector3, type Color, type Intersection, type Material, type Raycaster,
} from "three";
import type { Batch, Hit, Slot } from "./batch";
import { materialFor, withForm, type Appearance } from "./appearance";

export type Unit = "box" | "shaft" | "capsule";

// Segments of a full circle. There may be thousands of shapes, and a ball has many more triangles
// than a can.
const circleSegments = 48;
const ballSegments = 36;
const smallest = 16;

// The axis of three.js's round shapes is y.
const yToZ = Math.PI / 2;

function unitGeometry(unit: Unit): BufferGeometry {
  if (unit === "box") return new BoxGeometry(1, 1, 1);
  if (unit === "shaft") return new CylinderGeometry(1, 1, 1, circleSegments).rotateX(yToZ);
  return new CapsuleGeometry(1, 2, ballSegments / 4, ballSegments).rotateX(yToZ);
}

// The instance's true geometry for a ray that has hit its bounds, since the shader's form is not in
// the unit geometry.
function formedGeometry(unit: Unit, x: number, y: number): BufferGeometry {
  if (unit === "shaft") return new CylinderGeometry(y, x, 1, circleSegments).rotateX(yToZ);
  if (unit === "capsule") return new CapsuleGeometry(1, 2 * x, ballSegments / 4, ballSegments).rotateX(yToZ);
  return unitGeometry(unit);
}

export class ShapeBatch<Owner> implements Batch<Owner> {
  object: InstancedMesh;
  private readonly geometry: BufferGeometry;
  private readonly material: Material;
  private readonly slots: Slot<Owner>[] = [];

  // `replaced` is called if the instances no longer fit and a larger object replaces the old one.
  constructor(private readonly unit: Unit, appearance: Appearance, private readonly replaced: (before: InstancedMesh, now: InstancedMesh) => void) {
    this.geometry = unitGeometry(unit);
    const material = materialFor(appearance, false);
    this.material = unit === "box" ? material : withForm(material, unit);
    this.object = this.grown(smallest);
  }

  get count(): number { return this.slots.length; }

  add(owner: Owner, matrix: Matrix4, color: Color, form: readonly [number, number]): Slot<Owner> {
    const index = this.slots.length;
    if (index === this.object.instanceMatrix.count) this.grow();
    const slot: Slot<Owner> = { owner, index };
    this.slots.push(slot);
    this.object.count = this.slots.length;
    this.form.setXY(index, form[0], form[1]);
    this.form.needsUpdate = true;
    this.setMatrix(slot, matrix);
    this.setColor(slot, color);
    return slot;
  }

  setMatrix(slot: Slot<Owner>, matrix: Matrix4): void {
    this.object.setMatrixAt(slot.index, matrix);
    this.object.instanceMatrix.needsUpdate = true;
  }

  setColor(slot: Slot<Owner>, color: Color): void {
    this.object.setColorAt(slot.index, color);
    if (this.object.instanceColor) this.object.instanceColor.needsUpdate = true;
  }

  // The last instance moves to the freed place.
  remove(slot: Slot<Owner>): void {
    const last = this.slots.pop();
    if (last && last !== slot) {
      for (const attribute of [this.object.instanceMatrix, this.object.instanceColor, this.form]) {
        if (!attribute) continue;
        const size = attribute.itemSize;
        attribute.array.copyWithin(slot.index * size, last.index * size, (last.index + 1) * size);
        attribute.needsUpdate = true;
      }
      last.index = slot.index;
      this.slots[slot.index] = last;
    }
    this.object.count = this.slots.length;
  }

  hits(raycaster: Raycaster): Hit<Owner>[] {
    const found: Hit<Owner>[] = [];
    const matrix = new Matrix4();
    const reach = new Sphere();
    const scale = new Vector3();
    for (const { owner, index } of this.slots) {
      this.object.getMatrixAt(index, matrix);
      const [x, y] = [this.form.getX(index), this.form.getY(index)];
      scale.setFromMatrixScale(matrix);
      const height = this.unit === "capsule" ? x + 1 : 0.5;
      const width = this.unit === "box" ? 0.5 : 1;
      reach.set(new Vector3().setFromMatrixPosition(matrix), Math.hypot(scale.x * width, scale.y * width, scale.z * height));
      if (!raycaster.ray.intersectsSphere(reach)) continue;
      const nearest = this.meet(raycaster, matrix, x, y);
      if (nearest) found.push({ owner, distance: nearest.distance });
    }
    return found;
  }

  private meet(raycaster: Raycaster, matrix: Matrix4, x: number, y: number): Intersection | undefined {
    const mesh = new Mesh(formedGeometry(this.unit, x, y), this.material);
    mesh.matrixWorld.copy(matrix);
    const found: Intersection[] = [];
    mesh.raycast(raycaster, found);
    mesh.geometry.dispose();
    return found.sort((a, b) => a.distance - b.distance)[0];
  }

  private get form(): InstancedBufferAttribute { return this.object.geometry.getAttribute("form") as InstancedBufferAttribute; }

  private grown(capacity: number): InstancedMesh {
    const geometry = this.geometry.clone();
    geometry.setAttribute("form", new InstancedBufferAttribute(new Float32Array(2 * capacity), 2));
    const mesh = new InstancedMesh(geometry, this.material, capacity);
    mesh.instanceColor = new InstancedBufferAttribute(new Float32Array(3 * capacity), 3);
    for (const attribute of [mesh.instanceMatrix, mesh.instanceColor]) attribute.setUsage(DynamicDrawUsage);
    mesh.frustumCulled = false;  // its bounds would be recomputed at every change
    mesh.matrixAutoUpdate = false;
    mesh.count = 0;
    return mesh;
  }

  private grow(): void {
    const before = this.object;
    const now = this.grown(2 * before.instanceMatrix.count);
    now.instanceMatrix.array.set(before.instanceMatrix.array);
    if (now.instanceColor && before.instanceColor) now.instanceColor.array.set(before.instanceColor.array);
    (now.geometry.getAttribute("form").array as Float32Array).set(before.geometry.getAttribute("form").array);
    now.count = before.count;
    now.renderOrder = before.renderOrder;
    now.visible = before.visible;
    this.object = now;
    this.replaced(before, now);
    before.geometry.dispose();
    before.dispose();
  }
}
