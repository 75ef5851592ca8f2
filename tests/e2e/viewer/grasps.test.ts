// Grasps written by the planner and opened in the page: grippers at their poses, coloured by
// quality, and their state in the present world; also files that are not grasps.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, afterEach, before, beforeEach, test } from "node:test";
import type { Browser } from "playwright-core";
import { matrixOf } from "../../../clients/web/src/scene/pose";
import { scoreColor } from "../../../clients/web/src/viewer/grasps";
import type { Pose } from "../../../clients/web/src/world/types";
import { hue, hueDifference, openBrowser, OpenedPage, rgbOf } from "./opened_page";
import { RunningServer, until } from "./running_server";

let browser: Browser;
let server: RunningServer;
let page: OpenedPage;

before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

beforeEach(async () => {
  server = new RunningServer();
  await server.start();
});

afterEach(async () => {
  await page.close();
  await server.close();
});

interface Written {
  gripper: { boxes: { centre: number[]; size_m: number[] }[] };
  objects: { name: string; grasps: { score: number; way: string; width_m: number; x_world_grasp: Pose }[] }[];
}

const read = (path: string): Written => JSON.parse(readFileSync(path, "utf8")) as Written;

async function openGrasps(path: string): Promise<void> { await page.page.setInputFiles("input.file", path); }

async function show(scheme: "light" | "dark" = "light"): Promise<void> {
  page = await OpenedPage.open(browser, server.url, { colorScheme: scheme });
  await page.settle(Number((await server.json("objects"))["revision"]));
}

async function drawn(count: number): Promise<void> {
  await until(`${count} grippers were drawn`, async () => (await page.facts()).grippers === count);
  await page.settle(0);
}

const notes = (): Promise<string[]> => page.page.$$eval(".grasp .note", (all) => all.map(({ textContent }) => textContent ?? ""));

// The number of lines of each text; none is cut.
const lines = (...selectors: string[]): Promise<number[]> => page.page.evaluate((all) => all.map((selector) => {
  const place = document.querySelector<HTMLElement>(selector);
  if (!place || place.scrollWidth > place.clientWidth) return 0;
  const texts = document.createTreeWalker(place, NodeFilter.SHOW_TEXT);
  const bottoms = new Set<number>();
  while (texts.nextNode()) {
    const range = document.createRange();
    range.selectNodeContents(texts.currentNode);
    for (const { bottom } of range.getClientRects()) bottoms.add(Math.round(bottom / 8));
  }
  return bottoms.size;
}), selectors);

// A can and a box, each at most a hand's breadth wide, and a crate that no gripper can grasp.
async function putThings(): Promise<void> {
  await server.cwm("put", "can", "--cylinder", "0.03,0.14", "--at", "0,0,0.07");
  await server.cwm("put", "bar", "--box", "0.04,0.2,0.1", "--at", "0.6,0,0.05");
  await server.cwm("put", "crate", "--box", "0.3,0.3,0.3", "--at", "0,0.6,0.15");
}

// The position in the window of the middle of one of the gripper's boxes.
async function middleOf(box: { centre: number[] } | undefined, pose: Pose): Promise<{ x: number; y: number }> {
  const { elements: X } = matrixOf(pose);
  const [a = 0, b = 0, c = 0] = box?.centre ?? [];
  const at = (row: number): number => [X[row], X[4 + row], X[8 + row], X[12 + row]]
    .reduce<number>((sum, value, i) => sum + (value ?? 0) * ([a, b, c, 1][i] ?? 0), 0);
  return page.project(at(0), at(1), at(2));
}

test("grippers are where their grasps are, in the colour of their quality, in one draw call, and hidden by a key", async () => {
  await putThings();
  const path = await server.grasps("--top", "3");
  const { gripper, objects } = read(path);
  await show();
  const before = await page.pixels();
  const calls = (await page.facts()).draw_calls;
  await openGrasps(path);
  await drawn(2);
  assert.equal((await page.facts()).grasps, 6);
  assert.deepEqual(await lines(".grasps h2", ".grasps .of", ".grasps .all"), [1, 1, 1]);
  assert.equal(await page.page.textContent(".grasps .opening"), "opening 80 mm");
  assert.ok((await page.facts()).draw_calls - calls <= 2, "the grippers and the ways to them");
  const now = await page.pixels();
  await page.keep("grasps");
  const places: { x: number; y: number }[] = [];
  for (const { name, grasps } of objects) {
    const [best] = grasps;
    if (!best) continue;
    const palm = await middleOf(gripper.boxes.find(({ size_m }) => (size_m[0] ?? 0) > 0.1), best.x_world_grasp);
    assert.equal(hue(before(palm.x, palm.y)), undefined, `nothing was where the palm for ${name} comes to be`);
    const pixel = now(palm.x, palm.y);
    assert.ok(hueDifference(pixel, rgbOf(scoreColor(best.score))) < 14, `the palm for ${name}: ${pixel} is not ${scoreColor(best.score)}`);
    places.push(palm);
  }
  assert.equal(places.length, 2);
  await page.page.keyboard.press("k");
  await drawn(0);
  const after = await page.pixels();
  for (const { x, y } of places) assert.equal(hue(after(x, y)), undefined);
  await page.page.keyboard.press("k");
  await page.page.getByLabel("Draw all").check();
  await drawn(6);
  assert.deepEqual(page.complaints, []);
});

test("the list is ranked, a row or a click on a gripper chooses a grasp and its object", async () => {
  await putThings();
  const path = await server.grasps("--top", "2");
  const { gripper, objects } = read(path);
  const all = objects.flatMap(({ name, grasps }) => grasps.map((grasp) => ({ name, ...grasp }))).sort((a, b) => b.score - a.score);
  await show();
  await openGrasps(path);
  await drawn(2);
  const rows = await page.page.$$eval(".grasp", (list) => list.map(({ textContent }) => textContent ?? ""));
  for (const [i, { name, width_m, score, way, x_world_grasp: { tx_m, ty_m, tz_m } }] of all.entries()) {
    const place = [tx_m, ty_m, tz_m].map((value) => value.toFixed(3).replace(/^-(?=0\.0*$)/, "").replace("-", "\u2212")).join(" ");
    const head = `${i + 1}${name}${(1000 * width_m).toFixed(1)} mm${score.toFixed(2)}${way} ${place}`;
    assert.ok(rows[i]?.startsWith(head), `${rows[i]} is not ${head}`);
  }
  assert.equal(new Set(rows.map((row) => row.replace(/^\d+/, ""))).size, all.length, "each row tells its grasp from the others");
  assert.match(await page.page.textContent(".grasps") ?? "", /1 object without a grasp.*crate.*too wide/s);
  const last = all.at(-1);
  await page.page.locator(".grasp").last().click();
  await until("the last was chosen", async () => (await page.facts()).chosen_grasp === all.length);
  assert.equal((await page.facts()).selected, last?.name);
  await page.settle(0);
  await page.keep("grasp-chosen");
  await page.page.keyboard.press("ArrowUp");
  await page.page.keyboard.press("Enter");
  await until("the one above was chosen", async () => (await page.facts()).chosen_grasp === all.length - 1);
  const [first] = all;
  assert.ok(first);
  const { x, y } = await middleOf(gripper.boxes[2], first.x_world_grasp);
  await page.page.mouse.click(x, y);
  await until("the gripper was chosen", async () => (await page.facts()).chosen_grasp === 1);
  assert.equal((await page.facts()).selected, first.name);
  await page.page.getByText("crate", { exact: true }).first().click();
  assert.equal((await page.facts()).chosen_grasp, 0, "another object is selected");
});

test("grasps of what has moved, gone or was of another world are said to be stale", async () => {
  await putThings();
  const path = await server.grasps("--top", "1");
  await show();
  await openGrasps(path);
  await drawn(2);
  assert.deepEqual(await notes(), ["", ""]);
  assert.equal(await page.page.isVisible(".grasps .warning"), false);
  await server.cwm("move", "can", "--at", "0.2,0,0.07");
  await until("it was said", async () => (await notes()).sort().join() === ",moved since");
  assert.match(await page.page.textContent(".grasps .warning") ?? "", /Planned at revision 3, shown is 4/);
  await page.settle(4);
  const { gripper, objects } = read(path);
  const can = objects.find(({ name }) => name === "can")?.grasps[0];
  assert.ok(can);
  const { x, y } = await middleOf(gripper.boxes[2], can.x_world_grasp);
  assert.equal(hue((await page.pixels())(x, y)), undefined, "a stale gripper is grey");
  await server.cwm("remove", "can");
  await until("it was said", async () => (await notes()).sort().join() === ",gone");
  await server.stop();
  await server.start();
  await putThings();
  await until("it was said", async () => (await notes()).join() === "another world,another world");
  assert.match(await page.page.textContent(".grasps .warning") ?? "", /not the one shown/);
});

test("a file that holds no grasps is refused by the field, and what was open stays", async () => {
  await putThings();
  const path = await server.grasps();
  await show();
  const text = readFileSync(path, "utf8");
  const changed = (change: (of: any) => void): string => {
    const document: unknown = JSON.parse(text);
    change(document);
    return JSON.stringify(document);
  };
  await openGrasps(path);
  await drawn(2);
  const bad: [string, RegExp][] = [
    ["", /it is no JSON/],
    ["[1]", /the file is \[1\]: it must be an object/],
    ["{}", /objects is missing: it must be a list/],
    [changed((of) => { delete of.gripper; }), /gripper is missing: it must be an object/],
    [changed((of) => { of.objects[0].grasps[0].width_m = "wide"; }), /objects\[0\]\.grasps\[0\]\.width_m is "wide": it must be a number/],
    [changed((of) => { of.objects[0].grasps[0].score = 7; }), /objects\[0\]\.grasps\[0\]\.score is 7: it must be at most 1/],
    [changed((of) => { of.objects[0].grasps[0].x_world_grasp.qw = 9; }), /x_world_grasp has a quaternion of length 9\.\d+: it must be 1/],
    [changed((of) => { of.gripper.boxes[1].size_m[2] = -1; }), /gripper\.boxes\[1\]\.size_m\[2\] is -1: it must be at least 0/],
  ];
  for (const [content, message] of bad) {
    await openGrasps(server.write("bad.json", content));
    await until(`${message} was said`, async () => message.test(await page.page.textContent(".grasps .error") ?? ""));
    assert.match(await page.page.textContent(".grasps .error") ?? "", /^bad\.json: /);
    assert.equal((await page.facts()).grippers, 2);
  }
  await page.keep("grasps-refused");
  // A name is shown as text, whatever it contains.
  await openGrasps(server.write("odd.json", changed((of) => { of.objects[0].name = "<img src=x onerror=alert(1)>"; })));
  await until("it was shown", async () => (await page.page.textContent(".ranking") ?? "").includes("<img src=x"));
  assert.equal(await page.page.isVisible(".grasps .error"), false);
  await page.page.getByLabel("Put the grasps away").click();
  await drawn(0);
  assert.deepEqual(page.complaints, []);
});

test("a file that is dropped on the page is opened, and so is one that a key asks for", async () => {
  await putThings();
  const path = await server.grasps("--top", "1");
  await show();
  const transfer = await page.page.evaluateHandle((text) => {
    const data = new DataTransfer();
    data.items.add(new File([text], "grasps.json", { type: "application/json" }));
    return data;
  }, readFileSync(path, "utf8"));
  await page.page.dispatchEvent("main", "dragover", { dataTransfer: transfer });
  assert.ok(await page.page.evaluate(() => document.body.classList.contains("dropping")));
  await page.page.dispatchEvent("main", "drop", { dataTransfer: transfer });
  await drawn(2);
  assert.equal(await page.page.evaluate(() => document.body.classList.contains("dropping")), false);
  await page.page.getByLabel("Put the grasps away").click();
  await drawn(0);
  const chooser = page.page.waitForEvent("filechooser");
  await page.page.focus(".stage");
  await page.page.keyboard.press("o");
  await (await chooser).setFiles(path);
  await drawn(2);
});

test("the kitchen's grasps, for readers", async () => {
  await server.ingestKitchen();
  const path = await server.grasps();
  await show();
  await page.page.keyboard.press("p");
  await openGrasps(path);
  await page.page.locator(".grasp").first().click();
  await until("it was chosen", async () => (await page.facts()).chosen_grasp === 1);
  await page.settle(1);
  await page.keepSmall("viewer-grasps");
  await page.page.keyboard.press("t");
  await page.settle(1);
  await page.keep("grasps-dark");
  assert.deepEqual(page.complaints, []);
});
