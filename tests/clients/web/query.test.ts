// Typed queries and readable answers.
import assert from "node:assert/strict";
import { test } from "node:test";
import { parseResult } from "../../../clients/web/src/viewer/query_result";
import { examples, parseQuery as parse, QueryError, type Query } from "../../../clients/web/src/viewer/query";
import { ghostRequest, ghostsOf } from "../../../clients/web/src/viewer/robot_ghosts";
import { rowBetween } from "../../../clients/web/src/viewer/robot_state";
import type { Robot } from "../../../clients/web/src/world/stream";

interface Rows { data: string; }

// A lift below two turning joints, of which the second turns without end. The group has them in
// another order than the robot.
const arm: Robot = {
  name: "arm", uid: "arm@1", links: [], state: [0.5, 0.1, 0.2], state_revision: "1",
  variables: [{ name: "lift", joint: "lift", joint_kind: "JOINT_KIND_PRISMATIC" },
              { name: "turn", joint: "turn", joint_kind: "JOINT_KIND_REVOLUTE" },
              { name: "roll", joint: "roll", joint_kind: "JOINT_KIND_CONTINUOUS" }],
  groups: [{ name: "wrist", joints: ["roll", "turn"], states: [{ name: "ready", values: [{ variable: "turn", value: 1 }] }] },
           { name: "all", joints: ["lift", "turn", "roll"], states: [
             { name: "ready", values: [] }, { name: "up", values: [{ variable: "lift", value: 2 }] }] }] };

const panda: Robot = { ...arm, name: "panda", groups: [
  { name: "panda_arm", joints: ["turn", "roll"], states: [{ name: "ready", values: [{ variable: "turn", value: 1 }] }] }] };

const robots: Record<string, Robot> = { arm, panda };

const centres: Record<string, { x: number; y: number; z: number }> = {
  mug: { x: 1, y: 2, z: 3 }, "my mug": { x: 4, y: 5, z: 6 }, "1e+5": { x: 7, y: 8, z: 9 } };

const parseQuery = (text: string): Query =>
  parse(text, { centreOf: (name) => centres[name], robot: (name) => robots[name] });

const place = ({ tx_m, ty_m, tz_m }: { tx_m: number; ty_m: number; tz_m: number } = { tx_m: NaN, ty_m: NaN, tz_m: NaN }): number[] =>
  [tx_m, ty_m, tz_m].map((value) => Number(value.toFixed(9)));

const numbersOf = ({ data }: Rows): number[] => [...new Float64Array(new Uint8Array(Buffer.from(data, "base64")).buffer)];

test("a shape stands where at says, with and without a rotation", () => {
  const { method, request, at } = parseQuery("distance sphere 0.05 at 0.5 0 1");
  assert.equal(method, "QueryService/GetDistances");
  const { shapes } = request["subject"] as { shapes: { shapes: object[]; x_world_body: Rows } };
  assert.deepEqual(shapes.shapes, [{ sphere: { radius_m: 0.05 } }]);
  assert.deepEqual(numbersOf(shapes.x_world_body), [0.5, 0, 1, 0, 0, 0, 1]);
  assert.deepEqual(at[0], { tx_m: 0.5, ty_m: 0, tz_m: 1, qx: 0, qy: 0, qz: 0, qw: 1 });
  const turned = parseQuery("check box 1 2 3 at 0 0 0 0 0 1 0");
  assert.equal(turned.at[0]?.qz, 1);
  assert.equal(turned.method, "QueryService/CheckCollisions");
});

test("what the command line prints can be pasted", () => {
  const plain = parseQuery("contacts box 0.1 0.1 0.2 at 0.5 0 1 margin 0.01 max-contacts 4");
  assert.deepEqual(parseQuery("cwm contacts --box 0.1,0.1,0.2 --at=0.5,0,1 --margin 0.01 --max-contacts=4"), plain);
});

test("negative numbers are no options", () => {
  const { ray } = parseQuery("ray from -1 -2 -3 direction 0 0 -1");
  assert.deepEqual(ray, { from: [-1, -2, -3], direction: [0, 0, -1] });
});

test("a ray to a point goes towards it", () => {
  assert.deepEqual(parseQuery("ray from 1 1 1 to 2 1 0").ray?.direction, [1, 0, -1]);
});

test("objects and robots stand where they are, and names may have spaces", () => {
  assert.deepEqual(parseQuery('distance object "my mug"').request["subject"], { object: { name: "my mug" } });
  assert.deepEqual(parseQuery("check robot panda").request["subject"], { robot: { robot: "panda", group: "" } });
});

test("a place is an object's middle, or beside it by an offset along the world's axes", () => {
  for (const [text, expected] of [
    ["mug", [1, 2, 3]], ["mug+0,0,0.20", [1, 2, 3.2]], ["mug +0 0 -0.5", [1, 2, 2.5]], ["mug + 0.1 0 0", [1.1, 2, 3]],
    ['"my mug"+1,1,1', [5, 6, 7]], ['"1e+5"', [7, 8, 9]], ["1e+0 2 3", [1, 2, 3]]] as const) {
    assert.deepEqual(place(parseQuery(`distance sphere 0.1 at ${text}`).at[0]), expected, text);
  }
  const { ray } = parseQuery("ray --from mug+0,0,1 --to mug");
  assert.deepEqual(ray, { from: [1, 2, 4], direction: [0, 0, -1] });
});

test("a motion leads through all places, and a robot's through all states", () => {
  const body = parseQuery("motion sphere 0.1 at 0 0 1 at mug at 0 0 2 margin 0.01");
  assert.equal(body.method, "QueryService/CheckMotions");
  assert.deepEqual(body.request["path_row_counts"], [3]);
  assert.deepEqual(body.at.map(place), [[0, 0, 1], [1, 2, 3], [0, 0, 2]]);
  const robot = parseQuery("cwm motion --robot arm --group wrist --joints=-1,2 --joints ready");
  assert.deepEqual(robot.robot?.rows, [[-1, 2], [0.2, 1]]);
  assert.deepEqual(robot.request["path_row_counts"], [2]);
  const { rows } = (robot.request["subject"] as { robot: { rows: Rows & { width: number } } }).robot;
  assert.equal(rows.width, 2);
  assert.deepEqual(numbersOf(rows), [-1, 2, 0.2, 1]);
});

test("a state of a robot is numbers or has a name; what it leaves out stays as it is", () => {
  assert.deepEqual(parseQuery("check robot arm joints 1 2 3").robot?.rows, [[1, 2, 3]]);
  assert.deepEqual(parseQuery("check robot arm joints up").robot?.rows, [[2, 0.1, 0.2]]);
  assert.deepEqual(parseQuery("check robot arm group all joints ready at 0 0 1 scope self geometry exact").request["subject"], {
    robot: { robot: "arm", group: "all", x_world_base: { tx_m: 0, ty_m: 0, tz_m: 1, qx: 0, qy: 0, qz: 0, qw: 1 },
             rows: { scalar: "SCALAR_F64", data: Buffer.from(new Float64Array([0.5, 0.1, 0.2]).buffer).toString("base64"), width: 3 },
             scope: "ROBOT_SCOPE_SELF", robot_geometry: "ROBOT_GEOMETRY_EXACT" } });
});

test("samples are places up to the first option", () => {
  const { method, request, points } = parseQuery("sample 0.4,0,0.3 mug+0,0,0.1 0 0 0 max-distance 2 ignore mug");
  assert.equal(method, "QueryService/SamplePoints");
  assert.deepEqual(points.map((point) => point.map((value) => Number(value.toFixed(9)))), [[0.4, 0, 0.3], [1, 2, 3.1], [0, 0, 0]]);
  assert.equal(numbersOf(request["points"] as Rows).length, 9);
  assert.equal((request["options"] as Record<string, unknown>)["max_distance_m"], 2);
});

test("a robot is drawn in the asked states, and where its motion stops", () => {
  const query = parseQuery("motion robot arm group wrist joints 3,0 joints -3,1");
  const stopped = parseResult(query, { revision: "7", rows: [{ verdict: "MOTION_VERDICT_CONTACT", segment: 0, lo: 0.4999, hi: 0.5,
                                                              object: "mug", body_link: "hand", trust: "TRUST_EXACT" }] });
  assert.equal(stopped.title, "Meets mug at 50.0 % of segment 0");
  assert.deepEqual([stopped.verdict, stopped.touched, stopped.links], ["collision", ["mug"], [{ robot: "", link: "hand", row: -1 }]]);
  const request = ghostRequest(query, stopped, arm, "7") as { robot: { rows: Rows }; options: { at_revision: object } };
  assert.deepEqual(request.options.at_revision, { exact: "7" });
  const states = numbersOf(request.robot.rows);
  assert.equal(states.length, 6);
  assert.ok(Math.abs((states[4] as number) - Math.PI) < 1e-12, "roll turns the short way");
  assert.equal(states[5], 0.5);
  assert.equal(ghostRequest(parseQuery("check robot arm"), stopped, arm, "7"), undefined, "it is drawn there already");
});

test("poses of links are read row by row", () => {
  const pose = (x: number): number[] => [x, 0, 0, 0, 0, 0, 1];
  const data = Buffer.from(new Float64Array([1, 2, 3, 4].flatMap(pose)).buffer).toString("base64");
  const ghosts = ghostsOf({ links: ["base", "hand"], x_world_link: { scalar: "SCALAR_F64", data } });
  assert.deepEqual(ghosts.map((poses) => [...poses].map(([link, X]) => [link, X.elements[12]])),
                   [[["base", 1], ["hand", 2]], [["base", 3], ["hand", 4]]]);
});

test("joints with limits go the straight way", () => {
  assert.deepEqual(rowBetween(arm, "", [0, -3, 0], [1, 3, 1], 0.5), [0.5, 0, 0.5]);
});

test("options reach the request", () => {
  const options = parseQuery("distance object mug ignore a ignore b unseen report max-results 3 max-distance 2")
    .request["options"] as Record<string, unknown>;
  assert.deepEqual(options["ignore"], ["a", "b"]);
  assert.equal(options["unseen"], "UNSEEN_SPACE_REPORT");
  assert.equal(options["max_results"], 3);
  assert.equal(options["max_distance_m"], 2);
});

test("every example of the help is understood", () => {
  for (const example of examples) assert.ok(parseQuery(example));
});

const wrong: readonly (readonly [text: string, why: RegExp])[] = [
  ["", /begins with distance, contacts, check, motion, ray or sample/],
  ["toString", /begins with/],
  ["distance", /one shape, object NAME or robot NAME/],
  ["distance sphere", /sphere: R must be a number, found nothing/],
  ["distance box 1 2 at 0 0 0", /box: Z must be a number, found "at"/],
  ["distance sphere 1", /at X Y Z is missing/],
  ["distance sphere 1 box 1 1 1 at 0 0 0", /only one shape/],
  ["distance sphere 1 object mug at 0 0 0", /one shape, object NAME or robot NAME/],
  ["distance sphere 1 at 0 0 0 0 0 0 0", /length 1/],
  ["distance sphere 1 at 0 0 0 1", /QY must be a number/],
  ["distance constructor 1", /"constructor" is no word/],
  ["distance object", /a name is missing/],
  ["distance sphere Infinity at 0 0 0", /must be a number/],
  ["distance object mug max-results 1.5", /1, 2/],
  ["distance object mug unseen maybe", /ignore, report or block/],
  ["ray from 0 0 0", /one of direction X Y Z and to X Y Z/],
  ["ray direction 0 0 1", /from X Y Z is missing/],
  ["ray from 1 1 1 to 1 1 1", /must not be zero/],
  ["distance sphere 1 at cup", /there is no object "cup" in this world/],
  ["distance sphere 1 at mug+0,0", /DZ must be a number, found nothing; at NAME\+DX,DY,DZ takes DY DZ/],
  ["distance sphere 1 at mug+up,0,0", /DX must be a number, found "up"/],
  ["motion sphere 1 at 0 0 0", /leads through 1 place, must be at least 2: at twice or more/],
  ["motion robot arm", /joints twice or more/],
  ["check robot arm joints 1,2 joints 1", /has 1 numbers, must have 2 as the first/],
  ["check robot arm joints ready", /a state of wrist and all: say which with group/],
  ["check robot arm joints asleep", /numbers, one for each joint, or a named state: ready, ready, up/],
  ["check robot arm group leg joints ready", /no group "leg": wrist, all/],
  ["check robot bob joints ready", /there is no robot "bob"/],
  ["check robot arm at 0 0 0 at 0 0 1", /place of a robot's base, once/],
  ["check sphere 1 at 0 0 0 joints 1", /robot NAME is missing/],
  ["sample", /takes places/],
  ["check object mug what-if x", /only the command line/],
];

for (const [text, why] of wrong) {
  test(`"${text}" is refused with a reason`, () => {
    assert.throws(() => parseQuery(text), (error) => error instanceof QueryError && why.test(error.message));
  });
}

const origin = { x: 0, y: 0, z: 0 };

test("a distance is told by its pairs, with what is drawn of them", () => {
  const result = parseResult(parseQuery("distance sphere 0.05 at 0 0 1"), { revision: "3", rows: [{ answers: [
    { distance_m: 0.25, point_body: { x: 0, y: 0, z: 1 }, point_object: origin, normal: { x: 0, y: 0, z: -1 }, object: "mug",
      object_part: 0, trust: "TRUST_BOUNDED", bound_m: 0.001 }] }] });
  assert.equal(result.title, "250.00 mm away");
  assert.equal(result.verdict, "free");
  assert.deepEqual(result.rows[0]?.slice(0, 2), ["mug", "250.00 mm"]);
  assert.equal(result.rows[0]?.at(-1), "bounded, ± 1.000 mm");
  assert.equal(result.marks.length, 1);
});

test("a penetration is a collision, and nothing found says so", () => {
  const query = parseQuery("contacts sphere 0.05 at 0 0 1");
  const pair = { distance_m: -0.01, object: "mug", object_part: 0, trust: "TRUST_EXACT" };
  assert.match(parseResult(query, { revision: "1", rows: [{ answers: [pair, pair] }] }).title, /^2 contacts, deepest 10\.00 mm$/);
  const none = parseResult(query, { revision: "1", rows: [{ answers: [] }] });
  assert.deepEqual([none.title, none.verdict, none.marks.length], ["No contact", "free", 0]);
});

test("verdicts name what is met", () => {
  const query = parseQuery("check sphere 0.05 at 0 0 1");
  const collision = parseResult(query, { revision: "1", rows: [
    { verdict: "VERDICT_COLLISION", object: "panda", object_link: "hand", trust: "TRUST_EXACT" }] });
  assert.deepEqual([collision.title, collision.verdict], ["In collision with panda:hand", "collision"]);
  const undecided = parseResult(query, { revision: "1", rows: [{ verdict: "VERDICT_UNDECIDED", trust: "TRUST_DEGRADED" }] });
  assert.deepEqual([undecided.title, undecided.verdict], ["Undecided", "neutral"]);
});

test("a ray that hits nothing is drawn all the same", () => {
  const result = parseResult(parseQuery("ray from 0 0 0 direction 2 0 0"), { revision: "1", rows: [{ hit: false, trust: "TRUST_EXACT" }] });
  assert.equal(result.title, "Hits nothing");
  assert.deepEqual(result.marks[0]?.to, { x: 5, y: 0, z: 0 });
});

test("a robot that meets itself is told with its links", () => {
  const result = parseResult(parseQuery("check robot panda"), { revision: "1", rows: [
    { verdict: "VERDICT_COLLISION", body_link: "hand", object_link: "elbow", trust: "TRUST_EXACT" }] });
  assert.equal(result.title, "In collision with itself (hand, elbow)");
  assert.deepEqual(result.links, [{ robot: "", link: "hand", row: 0 }, { robot: "", link: "elbow", row: 0 }]);
});

test("several rows are numbered, and the nearest answer is the first mark", () => {
  const pair = (distance_m: number, object: string): object => ({
    distance_m, object, object_part: 0, trust: "TRUST_EXACT", point_body: origin, point_object: origin });
  const result = parseResult(parseQuery("distance sphere 0.1 at 0 0 1 at 0 0 2"), { revision: "1", rows: [
    { answers: [pair(0.3, "far")] }, { answers: [pair(0.1, "near"), pair(0.2, "far")] }] as never });
  assert.deepEqual(result.rows.map(([row, object]) => [row, object]), [["0", "far"], ["1", "near"], ["1", "far"]]);
  assert.deepEqual(result.marks.map(({ text }) => text), ["100.00 mm", "200.00 mm", "300.00 mm"]);
});

test("a sample is told by its distance, and a line leads to the nearest surface", () => {
  const query = parseQuery("sample 0 0 1 0 0 -0.1");
  const result = parseResult(query, { revision: "1", rows: [
    { state: "SAMPLE_STATE_SMOOTH", distance_m: 0.5, gradient: { x: 0, y: 0, z: 1 }, object: "table", trust: "TRUST_EXACT" },
    { state: "SAMPLE_STATE_KINK", distance_m: -0.1, gradient: { x: 0, y: 0, z: 1 }, object: "table", trust: "TRUST_EXACT" }] });
  assert.equal(result.title, "Inside table, 100.00 mm deep");
  assert.deepEqual(result.marks.map(({ to }) => to), [{ x: 0, y: 0, z: 0 }, { x: 0, y: 0, z: 0.5 }]);
  const beyond = parseResult(query, { revision: "1", rows: [{ state: "SAMPLE_STATE_BEYOND", trust: "TRUST_EXACT" }] });
  assert.deepEqual([beyond.title, beyond.marks.length], ["Nothing within reach", 0]);
});
