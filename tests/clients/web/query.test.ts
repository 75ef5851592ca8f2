// Typed queries and readable answers.
import assert from "node:assert/strict";
import { test } from "node:test";
import { parseResult } from "../../../clients/web/src/viewer/query_result";
import { examples, parseQuery, QueryError } from "../../../clients/web/src/viewer/query";

interface Rows { data: string; }

const numbersOf = ({ data }: Rows): number[] => [...new Float64Array(new Uint8Array(Buffer.from(data, "base64")).buffer)];

test("a shape stands where at says, with and without a rotation", () => {
  const { method, request, subject } = parseQuery("distance sphere 0.05 at 0.5 0 1");
  assert.equal(method, "QueryService/GetDistances");
  const { shapes } = request["subject"] as { shapes: { shapes: object[]; x_world_body: Rows } };
  assert.deepEqual(shapes.shapes, [{ sphere: { radius_m: 0.05 } }]);
  assert.deepEqual(numbersOf(shapes.x_world_body), [0.5, 0, 1, 0, 0, 0, 1]);
  assert.deepEqual(subject?.at, { tx_m: 0.5, ty_m: 0, tz_m: 1, qx: 0, qy: 0, qz: 0, qw: 1 });
  const turned = parseQuery("check box 1 2 3 at 0 0 0 0 0 1 0");
  assert.equal(turned.subject?.at.qz, 1);
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
  assert.deepEqual(parseQuery("check robot panda").request["subject"], { robot: { robot: "panda" } });
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
  ["", /begins with distance, contacts, check or ray/],
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
});
