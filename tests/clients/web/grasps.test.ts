// Grasp files as values: read, ranked and judged against a world; errors name the fault.
import assert from "node:assert/strict";
import { test } from "node:test";
import { checkSize, directionText, GraspFileError, parseGrasps, planWarning, scoreColor, staleness } from "../../../clients/web/src/viewer/grasps";
import { emptyWorld, type WorldState } from "../../../clients/web/src/viewer/world_model";
import type { WorldObject } from "../../../clients/web/src/world/types";

const pose = { tx_m: 0.1, ty_m: 0, tz_m: 0.2, qx: 0, qy: 0, qz: 0, qw: 1 };

const grasp = (score: number, more: object = {}): object => ({
  way: "box faces", score, width_m: 0.05, clearance_m: 0.01, x_world_grasp: pose, x_world_pregrasp: pose,
  contacts: [{ point: [0, 0, 0], normal: [1, 0, 0] }, { point: [0.05, 0, 0], normal: [-1, 0, 0] }], ...more });

const plan = (objects: object[], more: object = {}): string => JSON.stringify({
  world: "default", world_uid: "w1", revision: 7, objects,
  gripper: { opening_m: 0.08, boxes: [{ centre: [0, 0, 0], size_m: [0.2, 0.06, 0.06] }] }, ...more });

const refused = (text: string): string => {
  try {
    parseGrasps(text);
  } catch (error) {
    assert.ok(error instanceof GraspFileError, String(error));
    return error.message;
  }
  return assert.fail(`was read: ${text}`);
};

test("grasps are ranked over all objects, and the best of each is known", () => {
  const { grasps, graspless, opening_m, revision } = parseGrasps(plan([
    { name: "a", why: "", grasps: [grasp(0.6), grasp(0.5)] }, { name: "b", why: "", grasps: [grasp(0.9)] },
    { name: "c", why: "too wide", grasps: [] }]));
  assert.deepEqual(grasps.map(({ rank, object, isBest }) => [rank, object, isBest]), [[1, "b", true], [2, "a", true], [3, "a", false]]);
  assert.deepEqual(graspless, [{ object: "c", why: "too wide" }]);
  assert.deepEqual([opening_m, revision], [0.08, 7]);
});

test("what is wrong is named: the field, its value, the rule", () => {
  const one = (change: object): string => plan([{ name: "a", why: "", grasps: [grasp(0.5, change)] }]);
  assert.match(refused("{"), /^it is no JSON/);
  assert.equal(refused("null"), "the file is null: it must be an object");
  assert.equal(refused(plan([], { gripper: undefined })), "gripper is missing: it must be an object");
  assert.equal(refused(one({ score: -1 })), "objects[0].grasps[0].score is -1: it must be at least 0");
  assert.equal(refused(one({ score: null })), "objects[0].grasps[0].score is null: it must be a number");
  assert.match(refused(one({ x_world_grasp: { ...pose, qz: 1 } })), /^objects\[0\]\.grasps\[0\]\.x_world_grasp has a quaternion of length 1\.414/);
  assert.equal(refused(one({ x_world_pregrasp: undefined })), "objects[0].grasps[0].x_world_pregrasp is missing: it must be an object");
  assert.equal(refused(one({ contacts: [{ point: [1, 2], normal: [0, 0, 1] }] })),
               "objects[0].grasps[0].contacts[0].point is [1,2]: it must be three numbers");
  assert.equal(refused(plan([{ name: 5, grasps: [] }])), "objects[0].name is 5: it must be a text");
  assert.match(refused(plan([], { world: "x".repeat(5), revision: "7" })), /^revision is "7"/);
  assert.match(refused(one({ way: ["y".repeat(100)] })), /\u2026: it must be a text$/, "long values are cut");
});

test("too much is refused", () => {
  const many = Array.from({ length: 20_001 }, () => grasp(0.5));
  assert.match(refused(plan([{ name: "a", why: "", grasps: many }])), /grasps has 20001 entries: at most 20000/);
  assert.throws(() => checkSize(1e9), /1000 MB: at most 64 MiB/);
  checkSize(64 << 20);
});

function worldWith(world_uid: string, revision: string, object?: Partial<WorldObject>): WorldState {
  const revisions = { create_revision: "3", geometry_revision: "3", pose_revision: "5" };
  return { ...emptyWorld, world_uid, revision,
           objects: new Map(object ? [["a", { name: "a", ...revisions, ...object } as WorldObject]] : []) };
}

test("a grasp is as fresh as what it takes hold of", () => {
  const of = parseGrasps(plan([{ name: "a", why: "", grasps: [grasp(0.5)] }]));
  assert.equal(staleness(of, "a", worldWith("w1", "9", {})), "");
  assert.equal(staleness(of, "a", worldWith("w1", "9", { pose_revision: "8" })), "moved since");
  assert.equal(staleness(of, "a", worldWith("w1", "9", { geometry_revision: "8", pose_revision: "8" })), "reshaped since");
  assert.equal(staleness(of, "a", worldWith("w1", "9", { create_revision: "8" })), "another object now");
  assert.equal(staleness(of, "a", worldWith("w1", "9")), "gone");
  assert.equal(staleness(of, "a", worldWith("w2", "7", {})), "another world");
  assert.equal(planWarning(of, worldWith("w1", "7", {})), "");
  assert.match(planWarning(of, worldWith("w1", "9", {})), /revision 7, shown is 9/);
  assert.match(planWarning(of, worldWith("w2", "7", {})), /not the one shown/);
});

test("colours of quality are never near a grey", () => {
  for (let score = 0; score <= 1; score += 0.02) {
    const [r, g, b] = [1, 3, 5].map((at) => parseInt(scoreColor(score).slice(at, at + 2), 16)) as [number, number, number];
    assert.ok(Math.max(r, g, b) - Math.min(r, g, b) > 80, `${score}: ${scoreColor(score)}`);
  }
  assert.equal(scoreColor(-1), scoreColor(0));
  assert.equal(scoreColor(7), scoreColor(1));
});

test("a grasp is told by where it comes from and along what it closes", () => {
  const turned = (qx: number, qy: number, qz: number, qw: number): string =>
    directionText({ x_world_grasp: { tx_m: 0, ty_m: 0, tz_m: 0, qx, qy, qz, qw } } as Parameters<typeof directionText>[0]);
  const half = Math.SQRT1_2;
  assert.equal(turned(1, 0, 0, 0), "from above, closing along 0\u00b0");
  assert.equal(turned(half, half, 0, 0), "from above, closing along 90\u00b0");
  assert.equal(turned(0, 0, 0, 1), "from below, closing along 0\u00b0");
  // z turned to x, so that x points down.
  assert.equal(turned(0, half, 0, half), "towards 0\u00b0, 0\u00b0 down, closing upright");
  // Half a turn and a quarter of one about x: z points along -y and down.
  const [sine, cosine] = [Math.sin((3 * Math.PI) / 8), Math.cos((3 * Math.PI) / 8)];
  assert.equal(turned(sine, 0, 0, cosine), "towards 270\u00b0, 45\u00b0 down, closing along 0\u00b0");
});
