// Straight lines of one width in one draw call: frames, the box around the selection, marks of an
// result.
import { Color, Matrix4, Vector3, type Box3, type InterleavedBufferAttribute } from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";

export interface Segment { from: Vector3; to: Vector3; color: string; }

export class Lines {
  readonly object: LineSegments2;
  private count = 0;

  constructor(width_px: number, isOnTop: boolean) {
    const material = new LineMaterial({
      linewidth: width_px, vertexColors: true, transparent: true, depthWrite: false, depthTest: !isOnTop });
    this.object = new LineSegments2(new LineSegmentsGeometry(), material);
    this.object.frustumCulled = false;
    this.object.renderOrder = isOnTop ? 11 : 10;
    this.object.visible = false;
  }

  // As many segments as before are written into their buffers.
  set(segments: readonly Segment[]): void {
    this.object.visible = segments.length > 0;
    if (segments.length === 0) return;
    const color = new Color();
    const places = segments.flatMap(({ from, to }) => [...from, ...to]);
    const colors = segments.flatMap((segment) => {
      color.set(segment.color);
      return [...color, ...color];
    });
    if (segments.length === this.count) {
      this.overwrite("instanceStart", places);
      this.overwrite("instanceColorStart", colors);
      return;
    }
    this.count = segments.length;
    this.object.geometry.dispose();
    this.object.geometry = new LineSegmentsGeometry();
    this.object.geometry.setPositions(places);
    this.object.geometry.setColors(colors);
  }

  private overwrite(name: string, values: readonly number[]): void {
    const { data } = this.object.geometry.getAttribute(name) as InterleavedBufferAttribute;
    const { array } = data;
    let isSame = true;
    for (let i = 0; i < values.length; ++i) {
      const value = Math.fround(values[i] ?? 0);
      isSame &&= array[i] === value;
      array[i] = value;
    }
    if (!isSame) data.needsUpdate = true;
  }
}

// x red, y green, z blue, as everywhere.
const axisColors = ["#d8433b", "#3a9e4b", "#3b74e0"];

export function frameSegments(X: Matrix4, length_m: number): Segment[] {
  const origin = new Vector3().setFromMatrixPosition(X);
  return axisColors.map((color, i) => {
    const direction = new Vector3().setFromMatrixColumn(X, i).normalize();
    return { from: origin, to: origin.clone().addScaledVector(direction, length_m), color };
  });
}

// The twelve edges of a box placed at X.
export function boxSegments(box: Box3, X: Matrix4, color: string): Segment[] {
  const corner = (i: number): Vector3 => new Vector3(
    i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z).applyMatrix4(X);
  const segments: Segment[] = [];
  for (let i = 0; i < 8; ++i) {
    for (const step of [1, 2, 4]) {
      if (!(i & step)) segments.push({ from: corner(i), to: corner(i | step), color });
    }
  }
  return segments;
}

// An arrow's shaft and four barbs.
export function arrowSegments(from: Vector3, direction: Vector3, length_m: number, color: string): Segment[] {
  const along = direction.clone().normalize();
  const to = from.clone().addScaledVector(along, length_m);
  const aside = new Vector3(1, 0, 0).cross(along);
  if (aside.lengthSq() < 1e-3) aside.set(0, 1, 0).cross(along);
  aside.normalize();
  const other = along.clone().cross(aside);
  const barbs = [aside, aside.clone().negate(), other, other.clone().negate()].map((side) => ({
    from: to, to: to.clone().addScaledVector(along, -0.28 * length_m).addScaledVector(side, 0.12 * length_m), color }));
  return [{ from, to, color }, ...barbs];
}
