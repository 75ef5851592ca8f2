// Every kind of shape as triangles: extent, volume and winding.
import assert from "node:assert/strict";
import { test } from "node:test";
import { BufferGeometry, Vector3 } from "three";
import { meshSource } from "../../../clients/web/src/scene/mesh_geometry";
import { matrixOf } from "../../../clients/web/src/scene/pose";
import { shapeGeometry } from "../../../clients/web/src/scene/shape_geometry";
import type { ShapeOneOf } from "../../../clients/web/src/world/types";

const noMeshes = meshSource({});

function geometryOf(shape: ShapeOneOf): BufferGeometry {
  const geometry = shapeGeometry(shape, noMeshes);
  assert.ok(geometry);
  return geometry;
}

function boundsOf(geometry: BufferGeometry): { low: number[]; high: number[] } {
  geometry.computeBoundingBox();
  const box = geometry.boundingBox;
  assert.ok(box);
  return { low: box.min.toArray(), high: box.max.toArray() };
}

// The volume of a closed surface, positive if it is wound outwards (divergence theorem).
function signedVolume(geometry: BufferGeometry): number {
  const position = geometry.getAttribute("position");
  const corner = (i: number): Vector3 =>
    new Vector3().fromBufferAttribute(position, geometry.index ? geometry.index.getX(i) : i);
  const corners = geometry.index?.count ?? position.count;
  let volume = 0;
  for (let i = 0; i < corners; i += 3) {
    volume += corner(i).dot(corner(i + 1).cross(corner(i + 2))) / 6;
  }
  return volume;
}

function assertNear(actual: readonly number[], expected: readonly number[], tolerance: number): void {
  assert.equal(actual.length, expected.length);
  actual.forEach((value, i) => assert.ok(
    Math.abs(value - (expected[i] as number)) <= tolerance, `[${actual}] is not [${expected}]`));
}

const float32 = 1e-6;
// derived: with 64 chords a circle's area is (32 / pi) sin(2 pi / 64) of its true area, 0.16 %
// less; spheres lose about twice as much.
const chords = 0.005;

const cases: readonly { shape: ShapeOneOf; low: number[]; high: number[]; volume: number }[] = [
  { shape: { sphere: { radius_m: 0.2 } }, low: [-0.2, -0.2, -0.2], high: [0.2, 0.2, 0.2],
    volume: (4 / 3) * Math.PI * 0.008 },
  { shape: { box: { size_x_m: 0.2, size_y_m: 0.4, size_z_m: 0.6 } }, low: [-0.1, -0.2, -0.3],
    high: [0.1, 0.2, 0.3], volume: 0.048 },
  { shape: { cylinder: { radius_m: 0.05, length_m: 0.3 } }, low: [-0.05, -0.05, -0.15],
    high: [0.05, 0.05, 0.15], volume: Math.PI * 0.0025 * 0.3 },
  { shape: { capsule: { radius_m: 0.05, length_m: 0.3 } }, low: [-0.05, -0.05, -0.2],
    high: [0.05, 0.05, 0.2], volume: Math.PI * 0.0025 * 0.3 + (4 / 3) * Math.PI * 0.000125 },
  { shape: { half_space: {} }, low: [-10, -10, -1], high: [10, 10, 0], volume: 400 },
];

for (const { shape, low, high, volume } of cases) {
  test(`a ${Object.keys(shape)[0]} fills its extent and is wound outwards`, () => {
    const geometry = geometryOf(shape);
    const bounds = boundsOf(geometry);
    assertNear(bounds.low, low, float32);
    assertNear(bounds.high, high, float32);
    assertNear([signedVolume(geometry) / volume], [1], chords);
  });
}

test("a cone has its bottom radius at -z and its top radius at +z", () => {
  const geometry = geometryOf({ cone: { radius_bottom_m: 0.03, radius_top_m: 0.05, length_m: 0.1 } });
  const position = geometry.getAttribute("position");
  let bottom = 0;
  let top = 0;
  for (let i = 0; i < position.count; ++i) {
    const radius = Math.hypot(position.getX(i), position.getY(i));
    if (position.getZ(i) < 0) bottom = Math.max(bottom, radius);
    else top = Math.max(top, radius);
  }
  assertNear([bottom, top], [0.03, 0.05], float32);
  const volume = (Math.PI * 0.1 * (0.0009 + 0.0015 + 0.0025)) / 3;
  assertNear([signedVolume(geometry) / volume], [1], chords);
});

const square = (side: number): { vertices: { x: number; y: number }[] } => ({
  vertices: [{ x: 0, y: 0 }, { x: side, y: 0 }, { x: side, y: side }, { x: 0, y: side }] });

test("a plate lies below z = 0, keeps its holes, and its top is its first group", () => {
  const hole = { vertices: [{ x: 0.2, y: 0.2 }, { x: 0.4, y: 0.2 }, { x: 0.4, y: 0.4 }, { x: 0.2, y: 0.4 }] };
  const geometry = geometryOf({ plate: { outline: square(1), holes: [hole], thickness_m: 0.02 } });
  assertNear(boundsOf(geometry).low, [0, 0, -0.02], float32);
  assertNear(boundsOf(geometry).high, [1, 1, 0], float32);
  assertNear([signedVolume(geometry)], [0.02 * (1 - 0.04)], float32);
  const position = geometry.getAttribute("position");
  const [top, rest] = geometry.groups;
  assert.ok(top && rest && geometry.index);
  assert.equal(top.count + rest.count, geometry.index.count);
  for (let i = top.start; i < top.start + top.count; ++i) {
    assert.ok(Math.abs(position.getZ(geometry.index.getX(i))) < float32);
  }
});

test("a clockwise outline makes the same solid", () => {
  const outline = { vertices: square(1).vertices.reverse() };
  const geometry = geometryOf({ plate: { outline, holes: [], thickness_m: 0.02 } });
  assertNear([signedVolume(geometry)], [0.02], float32);
});

test("a mesh is the one of its hash, and an unknown hash is an empty one", () => {
  const base64 = (numbers: Float32Array | Uint32Array): string => Buffer.from(numbers.buffer).toString("base64");
  const meshes = meshSource({ beef: {
    vertices: base64(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0])), triangles: base64(new Uint32Array([0, 1, 2])) } });
  const geometry = shapeGeometry({ mesh: { hash: "beef" } }, meshes);
  assert.equal(geometry?.getAttribute("position").count, 3);
  assert.equal(geometry?.index?.count, 3);
  assert.equal(shapeGeometry({ convex: { hash: "dead" } }, meshes)?.getAttribute("position").count, 0);
});

test("a pose turns before it shifts", () => {
  const quarter = Math.SQRT1_2;  // about z
  const X_AB = matrixOf({ tx_m: 1, ty_m: 2, tz_m: 3, qx: 0, qy: 0, qz: quarter, qw: quarter });
  assertNear(new Vector3(1, 0, 0).applyMatrix4(X_AB).toArray(), [1, 3, 3], float32);
  assertNear(new Vector3(1, 0, 0).applyMatrix4(matrixOf(undefined)).toArray(), [1, 0, 0], 0);
});
