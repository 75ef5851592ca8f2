// Applies a watch's messages: no removal is lost, a revision is applied whole, unchanged objects
// keep their identity.
import assert from "node:assert/strict";
import { test } from "node:test";
import { rulesByPair, WorldModel } from "../../../clients/web/src/viewer/world_model";
import type { ObjectEvent, PairRule, Robot, WatchWorldResponse } from "../../../clients/web/src/world/stream";
import type { Pose, WorldObject } from "../../../clients/web/src/world/types";

const at = (x: number): Pose => ({ tx_m: x, ty_m: 0, tz_m: 0, qx: 0, qy: 0, qz: 0, qw: 1 });

const object = (name: string, x = 0): WorldObject => ({
  name, uid: `${name}@1`, kind: "OBJECT_KIND_USER", owner: "OWNER_USER", state: "OBJECT_STATE_CONFIRMED", x_world_object: at(x),
  shapes: [], surfaces: [], handles: [], supported_by: "", point_count: "0", create_revision: "1", geometry_revision: "1",
  pose_revision: "1", margin_m: 0, attached_to: "", motion: "MOTION_UNSPECIFIED", visibility: "VISIBILITY_UNSPECIFIED", carried_by: "" });

const robot = (name: string, state: number[]): Robot =>
  ({ name, uid: `${name}@1`, links: [], variables: [], groups: [], state, state_revision: "1" });

const initial = (revision: string, objects: WorldObject[], done = true, robots: Robot[] = []): WatchWorldResponse =>
  ({ world_uid: "w", revision, initial_state: { objects, initial_state_done: done, robots, pair_rules: [] } });

const events = (revision: string, list: ObjectEvent[], more = false): WatchWorldResponse =>
  ({ world_uid: "w", revision, events: { events: list, more, robot_events: [], pair_rules: [] } });

const names = (model: WorldModel): string[] => [...model.state.objects.keys()].sort();

test("the initial state counts once it is complete", () => {
  const model = new WorldModel();
  assert.equal(model.apply(initial("4", [object("a")], false)), false);
  assert.deepEqual(names(model), []);
  assert.equal(model.apply(initial("4", [object("b")])), true);
  assert.deepEqual(names(model), ["a", "b"]);
  assert.equal(model.state.revision, "4");
});

test("objects come, move and go", () => {
  const model = new WorldModel();
  model.apply(initial("1", [object("a"), object("b")]));
  const before = model.state;
  model.apply(events("2", [
    { put: object("c"), pose_revision: "0", motion: "MOTION_UNSPECIFIED" }, { remove: "a", pose_revision: "0", motion: "MOTION_UNSPECIFIED" },
    { move: { name: "b", x_world_object: at(3) }, pose_revision: "2", motion: "MOTION_MOVING" }]));
  assert.deepEqual(names(model), ["b", "c"]);
  assert.equal(model.state.objects.get("b")?.x_world_object?.tx_m, 3);
  assert.equal(model.state.objects.get("b")?.pose_revision, "2");
  assert.equal(model.state.objects.get("b")?.motion, "MOTION_MOVING");
  assert.deepEqual([...before.objects.keys()].sort(), ["a", "b"], "a state that was read stays as it was");
  assert.equal(before.objects.get("b")?.x_world_object?.tx_m, 0);
});

test("a revision in several messages shows as one", () => {
  const model = new WorldModel();
  model.apply(initial("1", [object("a")]));
  assert.equal(model.apply(events("2", [{ remove: "a", pose_revision: "0", motion: "MOTION_UNSPECIFIED" }], true)), false);
  assert.deepEqual(names(model), ["a"]);
  assert.equal(model.apply(events("2", [{ put: object("b"), pose_revision: "0", motion: "MOTION_UNSPECIFIED" }])), true);
  assert.deepEqual(names(model), ["b"]);
});

test("a new watch replaces all, and what is unchanged stays the same value", () => {
  const model = new WorldModel();
  model.apply(initial("1", [object("a"), object("b"), object("gone")]));
  const { objects } = model.state;
  model.apply(events("2", [{ remove: "b", pose_revision: "0", motion: "MOTION_UNSPECIFIED" }], true));  // cut off in the middle
  model.restart();
  model.apply(initial("9", [object("a"), object("b", 1)]));
  assert.deepEqual(names(model), ["a", "b"]);
  assert.equal(model.state.objects.get("a"), objects.get("a"));
  assert.notEqual(model.state.objects.get("b"), objects.get("b"));
});

test("robots move by events of their state", () => {
  const model = new WorldModel();
  model.apply(initial("1", [], true, [robot("arm", [0]), robot("other", [5])]));
  model.apply({ world_uid: "w", revision: "2", events: { events: [], more: false, pair_rules: [], robot_events: [
    { state: { name: "arm", state: [1], state_revision: "2" } }, { remove: "other" }] } });
  assert.deepEqual([...model.state.robots.keys()], ["arm"]);
  assert.deepEqual(model.state.robots.get("arm")?.state, [1]);
});

test("a rule that allows nothing and sets no margin is no more, whichever way round it is named", () => {
  const rule = (a: string, b: string, more: Partial<PairRule>): WatchWorldResponse => ({ world_uid: "w", revision: "2", events: {
    events: [], more: false, robot_events: [],
    pair_rules: [{ pair: { a: { name: a, link: "" }, b: { name: b, link: "" } }, allowed: false, ...more }] } });
  const model = new WorldModel();
  model.apply(initial("1", []));
  model.apply(rule("a", "b", { allowed: true }));
  model.apply(rule("b", "a", { margin_m: 0.1 }));
  assert.equal(model.state.rules.size, 1);
  model.apply(rule("a", "b", {}));
  assert.equal(model.state.rules.size, 0);
});

test("rules that nobody changes stay the same value, through changes of others and a reconnection", () => {
  const rules: PairRule[] = [{ pair: { a: { name: "a", link: "" }, b: { name: "b", link: "" } }, allowed: true }];
  const begin = (revision: string): WatchWorldResponse => ({ world_uid: "w", revision, initial_state: {
    objects: [object("a")], initial_state_done: true, robots: [], pair_rules: structuredClone(rules) } });
  const model = new WorldModel();
  model.apply(begin("1"));
  const before = model.state.rules;
  assert.equal(before.size, 1);
  model.apply(events("2", [{ move: { name: "a", x_world_object: at(3) }, pose_revision: "2", motion: "MOTION_UNSPECIFIED" }]));
  assert.equal(model.state.rules, before);
  model.restart();
  model.apply(begin("3"));
  assert.equal(model.state.rules, before);
  model.apply({ world_uid: "w", revision: "4", events: { events: [], more: false, robot_events: [], pair_rules: [
    { pair: { a: { name: "a", link: "" }, b: { name: "*", link: "" } }, allowed: false, margin_m: 0.1 }] } });
  assert.equal(model.state.rules.size, 2);
  assert.equal(before.size, 1);
  assert.deepEqual([...rulesByPair([...model.state.rules.values()])], [...model.state.rules]);
});

test("a sighting is noted and makes no revision of the picture", () => {
  const model = new WorldModel();
  model.apply(initial("1", [object("a")]));
  const { objects } = model.state;
  const seen = "2026-01-01T00:00:00Z";
  assert.equal(model.apply({ world_uid: "w", revision: "1", bookmark: { last_observed: { a: seen, nobody: seen }, facts: {} } }), false);
  assert.equal(model.state.objects, objects);
  assert.equal(model.state.objects.get("a")?.last_observed, seen);
});

test("facts of sensors make no revision, but another object to draw, and only if they are new", () => {
  const model = new WorldModel();
  model.apply(initial("1", [object("a"), object("b")]));
  const before = model.state.objects;
  const facts = { motion: "MOTION_AT_REST", visibility: "VISIBILITY_OCCLUDED", identity_certain: false, carried_by: "arm/hand" };
  const bookmark = (): WatchWorldResponse => ({ world_uid: "w", revision: "1", bookmark: { last_observed: {}, facts: { a: facts, nobody: facts } } });
  assert.equal(model.apply(bookmark()), true);
  assert.equal(model.state.revision, "1");
  const { objects } = model.state;
  assert.deepEqual(objects.get("a"), { ...before.get("a"), ...facts });
  assert.equal(objects.get("b"), before.get("b"));
  assert.equal(before.get("a")?.visibility, "VISIBILITY_UNSPECIFIED");
  assert.deepEqual(names(model), ["a", "b"]);
  assert.equal(model.apply(bookmark()), false);
  assert.equal(model.state.objects, objects);
  // Without the optional fact, the one before is over.
  const { identity_certain: _, ...rest } = facts;
  model.apply({ world_uid: "w", revision: "1", bookmark: { last_observed: {}, facts: { a: rest } } });
  assert.equal(model.state.objects.get("a")?.identity_certain, undefined);
});

test("events of what is not there change nothing", () => {
  const model = new WorldModel();
  model.apply(initial("1", [object("a")]));
  model.apply(events("2", [{ remove: "nobody", pose_revision: "0", motion: "MOTION_UNSPECIFIED" }, { move: { name: "nobody" }, pose_revision: "2", motion: "MOTION_UNSPECIFIED" }]));
  assert.deepEqual(names(model), ["a"]);
});
