// Objects as instances, stable colours, labels of points, meshes in the server's encoding.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Matrix4, Raycaster, SphereGeometry, Vector3, type BufferGeometry } from "three";
import { ColorAssignment } from "../../../clients/web/src/viewer/color_assignment";
import { MeshLibrary, meshOf } from "../../../clients/web/src/viewer/draw/blobs";
import { ownerOfLabel } from "../../../clients/web/src/viewer/draw/cloud";
import { hiddenParts, partsOf, type Part } from "../../../clients/web/src/viewer/draw/parts";
import { MeshBatch } from "../../../clients/web/src/viewer/draw/mesh_batch";
import { ShapeBatch } from "../../../clients/web/src/viewer/draw/shape_batch";
import { WorldView, type DrawnObject } from "../../../clients/web/src/viewer/draw/world_view";
import { SceneObjectList } from "../../../clients/web/src/viewer/scene_objects";
import { backOff_ms } from "../../../clients/web/src/viewer/messages";
import { objectColors } from "../../../clients/web/src/scene/palette";
import type { ShapeOneOf, ShapePart, WorldObject } from "../../../clients/web/src/world/types";
import { Color } from "three";

function objectOf(shapes: ShapeOneOf[], more: Partial<WorldObject> = {}): WorldObject {
  return { name: "thing", uid: "thing@1", kind: "OBJECT_KIND_OBJECT", owner: "OWNER_PERCEPTION", state: "OBJECT_STATE_CONFIRMED",
           shapes: shapes.map((shape) => ({ ...shape, role: "PART_ROLE_FITTED", coefficients: [] })), surfaces: [], handles: [],
           supported_by: "", point_count: "0", create_revision: "1", geometry_revision: "1", pose_revision: "1", margin_m: 0,
           attached_to: "", motion: "MOTION_UNSPECIFIED", visibility: "VISIBILITY_UNSPECIFIED", carried_by: "", ...more };
}

const sizes = (part: Part | undefined): number[] =>
  (part ? new Vector3().setFromMatrixScale(part.local).toArray().map((value) => Number(value.toFixed(9))) : []);

test("shapes become unit geometries, scaled", () => {
  const [ball, box, can] = partsOf(objectOf([
    { sphere: { radius_m: 0.1 } }, { box: { size_x_m: 1, size_y_m: 2, size_z_m: 3 } }, { cylinder: { radius_m: 0.2, length_m: 0.5 } }]));
  assert.deepEqual(sizes(ball), [0.1, 0.1, 0.1]);
  assert.deepEqual(sizes(box), [1, 2, 3]);
  assert.deepEqual(sizes(can), [0.2, 0.2, 0.5]);
});

test("the space into which a part may extend is drawn as unseen, in its own box", () => {
  const object = objectOf([{ box: { size_x_m: 1, size_y_m: 2, size_z_m: 3 } }, { sphere: { radius_m: 0.1 } }]);
  (object.shapes[0] as ShapePart).hidden = {
    x_object_box: { tx_m: 0.5, ty_m: 0, tz_m: 0, qx: 0, qy: 0, qz: 0, qw: 1 }, box: { size_x_m: 2, size_y_m: 2, size_z_m: 3 } };
  const [part, ...none] = hiddenParts(object);
  assert.deepEqual([part?.appearance, sizes(part), part?.local.elements[12], none.length], ["unseen", [2, 2, 3], 0.5, 0]);
});

test("a cone and a capsule carry their form", () => {
  const [cone, capsule] = partsOf(objectOf([
    { cone: { radius_bottom_m: 0.1, radius_top_m: 0.2, length_m: 1 } }, { capsule: { radius_m: 0.1, length_m: 0.6 } }]));
  assert.deepEqual(cone?.geometry, { is: "unit", unit: "shaft", form: [0.5, 1] });
  assert.deepEqual(sizes(cone), [0.2, 0.2, 1]);
  assert.ok(capsule?.geometry.is === "unit" && Math.abs(capsule.geometry.form[0] - 3) < 1e-12);
});

test("the top of a support was measured, its body completed", () => {
  const plate = { outline: { vertices: [] }, holes: [], thickness_m: 0.02 };
  const fit = { rms_m: 0, max_residual_m: 0, inlier_count: "1", inlier_ratio: 1, observed_fraction: 1, parameter_sigma: [] };
  const object = objectOf([]);
  object.shapes = [{ plate, role: "PART_ROLE_COMPLETED", coefficients: [], fit }];
  assert.deepEqual(partsOf(object).map(({ appearance }) => appearance), ["solid", "completed"]);
});

test("unseen space looks like nothing else", () => {
  const [part] = partsOf(objectOf([{ box: { size_x_m: 1, size_y_m: 1, size_z_m: 1 } }], { kind: "OBJECT_KIND_UNSEEN" }));
  assert.equal(part?.appearance, "unseen");
});

test("a mover is translucent, and what is out of sight striped where it was measured", () => {
  const box = { box: { size_x_m: 1, size_y_m: 1, size_z_m: 1 } };
  assert.deepEqual(partsOf(objectOf([box, box], { kind: "OBJECT_KIND_MOVER" })).map(({ appearance }) => appearance), ["mover", "mover"]);
  const stale = objectOf([box, box], { visibility: "VISIBILITY_STALE" });
  (stale.shapes[1] as ShapePart).role = "PART_ROLE_COMPLETED";
  assert.deepEqual(partsOf(stale).map(({ appearance }) => appearance), ["stale", "completed"]);
});

test("a move and what sensors say change no part, but for stripes", () => {
  const list = new SceneObjectList();
  const object = objectOf([{ sphere: { radius_m: 0.1 } }], { visibility: "VISIBILITY_VISIBLE" });
  const drawnOf = (now: WorldObject): DrawnObject => {
    list.update({ world_uid: "w", revision: "1", objects: new Map([[now.name, now]]), robots: new Map(), rules: new Map() }, new Map());
    return list.byName.get(now.name)?.drawn ?? assert.fail("it is not listed");
  };
  const first = drawnOf(object);
  const moved = drawnOf({ ...object, pose_revision: "2", motion: "MOTION_MOVING", x_world_object: { tx_m: 1, ty_m: 0, tz_m: 0, qx: 0, qy: 0, qz: 0, qw: 1 } });
  assert.equal(moved.parts, first.parts);
  assert.equal(moved.shape, first.shape);
  const hidden = drawnOf({ ...object, visibility: "VISIBILITY_OCCLUDED" });
  assert.deepEqual([hidden.parts === first.parts, hidden.shape === first.shape, hidden.color === first.color], [true, true, false]);
  const stale = drawnOf({ ...object, visibility: "VISIBILITY_STALE" });
  assert.notEqual(stale.shape, first.shape);
});

test("instances stay with their owners when others go and when there are many", () => {
  const batch = new ShapeBatch<string>("box", "solid", () => undefined);
  const place = (x: number): Matrix4 => new Matrix4().makeTranslation(x, 0, 0);
  const slots = Array.from({ length: 100 }, (_, i) => batch.add(`${i}`, place(i), new Color(i / 100, 0, 0), [i, 0]));
  for (let i = 0; i < 100; i += 3) batch.remove(slots[i] as (typeof slots)[0]);
  assert.equal(batch.count, 66);
  const matrix = new Matrix4();
  const color = new Color();
  slots.forEach((slot, i) => {
    if (i % 3 === 0) return;
    batch.object.getMatrixAt(slot.index, matrix);
    batch.object.getColorAt(slot.index, color);
    assert.equal(new Vector3().setFromMatrixPosition(matrix).x, i);
    assert.ok(Math.abs(color.r - i / 100) < 1e-6);
    assert.equal(batch.object.geometry.getAttribute("form").getX(slot.index), i);
  });
});

test("an object keeps its colour while others come and go, and neighbours differ", () => {
  const colors = new ColorAssignment();
  const named = (name: string, x: number): WorldObject =>
    objectOf([], { name, x_world_object: { tx_m: x, ty_m: 0, tz_m: 0, qx: 0, qy: 0, qz: 0, qw: 1 } });
  const row = Array.from({ length: 3 * objectColors.length }, (_, i) => named(`thing_${i}`, i));
  colors.update(row);
  const before = row.map(({ name }) => colors.of(name));
  before.slice(1).forEach((color, i) => assert.notEqual(color, before[i]));
  const fewer = row.filter((_, i) => i % 2 === 0);
  colors.update([...fewer, named("new", 0.5)]);
  fewer.forEach(({ name }, i) => assert.equal(colors.of(name), before[2 * i]));
  assert.notEqual(colors.of("new"), colors.of("thing_0"));
});

test("labels name their owners", () => {
  const scan = { sensor: "", revision: "1", point_count: "0", kept_count: "0", points_hash: "", labels_hash: "",
                 supports: ["table"], objects: ["mug", "box"] };
  assert.deepEqual([0, 1, 2, 20, 29, 30, 99].map((label) => ownerOfLabel(label, scan)),
                   [undefined, "table", undefined, "mug", "mug", "box", undefined]);
});

test("a mesh is read as it is sent, and what is no mesh is refused", () => {
  const bytes = new ArrayBuffer(8 + 24 * 3 + 12);
  new Uint32Array(bytes, 0, 2).set([3, 1]);
  new Float64Array(bytes, 8, 9).set([0, 0, 0, 1, 0, 0, 0, 1, 0]);
  new Uint32Array(bytes, 8 + 72, 3).set([0, 1, 2]);
  const mesh = meshOf(bytes);
  assert.equal(mesh.getAttribute("position").count, 3);
  assert.deepEqual([...(mesh.index?.array ?? [])], [0, 1, 2]);
  assert.throws(() => meshOf(bytes.slice(0, 40)), /40 bytes, must be 92/);
  assert.throws(() => meshOf(new ArrayBuffer(3)), /3 bytes/);
});

test("attempts to connect begin soon and never wait long", () => {
  const waits = Array.from({ length: 12 }, (_, i) => backOff_ms(i));
  assert.ok((waits[0] ?? Infinity) <= 100);
  assert.ok(waits.every((wait, i) => i === 0 || wait >= (waits[i - 1] ?? 0)));
  assert.equal(waits.at(-1), 3000);
});

// A ball with 33 x (rings + 1) vertices.
const ball = (rings: number): BufferGeometry => new SphereGeometry(1, 32, rings);

test("meshes are replaced as often as they change, the last one of an appearance too", () => {
  const batch = new MeshBatch<string>("solid");
  for (let k = 0; k < 12; ++k) {
    const slot = batch.add("alone", `mesh ${k}`, ball(30 + 7 * (k % 5)), new Matrix4(), new Color("red"));
    assert.equal(batch.count, 1);
    batch.remove(slot);
    assert.equal(batch.count, 0);
  }
  const slots = Array.from({ length: 20 }, (_, k) => batch.add(`${k}`, `many ${k}`, ball(40), new Matrix4(), new Color("red")));
  for (const slot of slots) batch.remove(slot);
  batch.add("last", "last", ball(60), new Matrix4(), new Color("red"));
  assert.equal(batch.count, 1);
});

// A cube of 0.2 m at x, with the appearance of its role or kind.
function cubeAt(name: string, x: number, role: "PART_ROLE_FITTED" | "PART_ROLE_COMPLETED", kind = "OBJECT_KIND_OBJECT"): DrawnObject {
  const object = objectOf([{ box: { size_x_m: 0.2, size_y_m: 0.2, size_z_m: 0.2 } }], { kind });
  object.shapes = object.shapes.map((shape) => ({ ...shape, role }));
  return { name, color: "#888888", shape: name, frames: [new Matrix4().makeTranslation(x, 0, 0)],
           parts: partsOf(object).map((part) => ({ frame: 0, part })) };
}

test("what was completed is pointed at as what was measured is; unseen space and movers let through", () => {
  const view = new WorldView(new MeshLibrary(assert.fail), () => undefined);
  const ray = new Raycaster(new Vector3(-5, 0, 0), new Vector3(1, 0, 0));
  const show = (...objects: DrawnObject[]): void => view.sync(new Map(objects.map((object) => [object.name, object])));
  const back = cubeAt("back", 3, "PART_ROLE_FITTED");
  show(back, cubeAt("hatched", 1, "PART_ROLE_COMPLETED"));
  assert.equal(view.pick(ray)?.owner, "hatched");
  show(back, cubeAt("dotted", 0, "PART_ROLE_FITTED", "OBJECT_KIND_UNSEEN"));
  assert.equal(view.pick(ray)?.owner, "back");
  show(back, cubeAt("hand", 1, "PART_ROLE_FITTED", "OBJECT_KIND_MOVER"));
  assert.equal(view.pick(ray)?.owner, "back");
  show(cubeAt("dotted", 0, "PART_ROLE_FITTED", "OBJECT_KIND_UNSEEN"));
  assert.equal(view.pick(ray)?.owner, "dotted");
});

// The MESH_F64 encoding of one triangle.
function triangleBytes(): ArrayBuffer {
  const bytes = new ArrayBuffer(8 + 24 * 3 + 12);
  new Uint32Array(bytes, 0, 2).set([3, 1]);
  new Float64Array(bytes, 8, 9).set([0, 0, 0, 1, 0, 0, 0, 1, 0]);
  new Uint32Array(bytes, 8 + 72, 3).set([0, 1, 2]);
  return bytes;
}

test("of meshes that nobody uses the oldest go, and as many stay as are worth keeping", async () => {
  let fetched = 0;
  const library = new MeshLibrary(assert.fail, () => {
    ++fetched;
    return Promise.resolve(triangleBytes());
  });
  const name = (i: number): string => `mesh ${i}`;
  for (let i = 0; i < 600; ++i) await library.get(name(i), () => true);
  library.trim((hash) => hash === name(0));
  assert.equal(library.size, 500);
  assert.ok(library.now(name(0)), "is used");
  assert.equal(library.now(name(1)), undefined);
  assert.ok(library.now(name(599)), "came last");
  await library.get(name(599), () => true);
  assert.equal(fetched, 600);
  const twice = await Promise.all([library.get(name(1), () => true), library.get(name(1), () => true)]);
  assert.equal(fetched, 601, "who asks meanwhile waits for the same");
  assert.equal(twice[0], twice[1]);
});

test("a mesh that cannot be had is told once, and fetched when it is asked for again", async () => {
  const told: string[] = [];
  const answers = [Promise.reject(new Error("404")), Promise.resolve(triangleBytes())];
  const library = new MeshLibrary((why) => told.push(why), () => answers.shift() ?? Promise.reject(new Error("asked too often")));
  assert.equal(await library.get("mesh", () => true), undefined);
  assert.deepEqual(told, ["404"]);
  assert.ok(await library.get("mesh", () => true));
});
