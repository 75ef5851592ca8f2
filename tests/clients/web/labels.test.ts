// Labels over the picture: which are shown, and where.
import assert from "node:assert/strict";
import { test } from "node:test";
import { PerspectiveCamera, Vector3 } from "three";
import { spotsOf, type Label, type LabelSpace } from "../../../clients/web/src/viewer/draw/labels";

// At the origin, looking along -z, 90 degrees wide and high.
const camera = new PerspectiveCamera(90, 1, 0.1, 100);
camera.updateMatrixWorld();
const space: LabelSpace = { width: 400, height: 400, covered: 150 };

const mark = (text: string, x: number, y: number, z: number): Label => ({ text, at: new Vector3(x, y, z), kind: "mark" });
const name = (text: string, x: number, y: number, z: number): Label => ({ ...mark(text, x, y, z), kind: "name" });

const texts = (labels: readonly Label[]): string[] => spotsOf(labels, camera, space).map(({ label }) => label.text);

test("the first mark is shown wherever its place is, whole and not below a panel", () => {
  for (const at of [[0, 0, -5], [30, 0, -5], [-30, 0, -5], [0, 30, -5], [0, -4, -5], [0, -30, -5], [1, 1, 5], [0, 0, -200]]) {
    const [x = 0, y = 0, z = 0] = at;
    const [spot] = spotsOf([mark("108.90 mm", x, y, z)], camera, space);
    assert.ok(spot, `${at}`);
    assert.ok(spot.x - spot.width / 2 >= 0 && spot.x + spot.width / 2 <= space.width, `${at}: x ${spot.x}`);
    assert.ok(spot.y >= 29 && spot.y <= space.height - space.covered, `${at}: y ${spot.y}`);
  }
});

test("what is to the right and behind is at the right border", () => {
  const [spot] = spotsOf([mark("a", 3, 0, 1)], camera, space);
  assert.ok(spot && spot.x > 380, `${spot?.x}`);
});

test("the first mark is not hidden by a mark or a name that is nearer to the camera", () => {
  const seen = texts([mark("nearest answer", 0, 0, -5), mark("another", 0, 0, -1), name("object", 0, 0, -1)]);
  assert.equal(seen[0], "nearest answer");
  assert.ok(seen.includes("another"), "a mark gives way upwards or downwards");
  assert.ok(!seen.includes("object"), "a name does not");
});

test("further marks are shown only where their places are seen", () => {
  assert.deepEqual(texts([mark("first", 0, 2, -5), mark("aside", 30, 0, -5), mark("behind", 0, 0, 5), mark("below", 0, -4, -5)]), ["first"]);
});

test("of names that overlap the nearest is shown", () => {
  assert.deepEqual(texts([name("far", 0, 0, -9), name("near", 0, 0, -3), name("aside", 2, 0, -4)]), ["near", "aside"]);
});
