// The page while a sensor runs: an arm lifts a can from the counter and puts it down elsewhere, and a
// hand passes by.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { after, before, test } from "node:test";
import type { Browser } from "playwright-core";
import { openBrowser, OpenedPage, type DrawnObject } from "./opened_page";
import { pause, RunningServer, until } from "./running_server";

// The simulator's example of an arm. It stands still at first, so that the scene is interpreted, and
// holds the can up while the hand passes by.
const base_m = "0.55,-0.5,0.9";
const arm = resolve("clients/simulator/examples/arm.urdf");
const still_s = 4;
const holds_s = 8;
const rests_s = 15.6;
const duration_s = 21;
const script = `
scene: kitchen
duration_s: ${duration_s}
robots:
  - name: arm
    urdf: ${arm}
    pose: {position_m: [${base_m}]}
    joints: [turn, lift, elbow, wrist]
    trajectory:
      - {time_s: 0, values: [0.6, 0.2, 1.6, 1.3]}
      - {time_s: 4, values: [0.6, 0.2, 1.6, 1.3]}
      - {time_s: 5, values: [1.36, 0.62, 1.545, 0.977]}
      - {time_s: 5.6, values: [1.36, 0.933, 1.616, 0.592]}
      - {time_s: 6, values: [1.36, 0.933, 1.616, 0.592]}
      - {time_s: 6.6, values: [1.36, 0.62, 1.545, 0.977]}
      - {time_s: 11.8, values: [1.36, 0.62, 1.545, 0.977]}
      - {time_s: 12.8, values: [1.95, 0.62, 1.545, 0.977]}
      - {time_s: 13.4, values: [1.95, 0.933, 1.616, 0.592]}
      - {time_s: 13.8, values: [1.95, 0.933, 1.616, 0.592]}
      - {time_s: 14.4, values: [1.95, 0.62, 1.545, 0.977]}
      - {time_s: 15.4, values: [0.6, 0.2, 1.6, 1.3]}
      - {time_s: 21, values: [0.6, 0.2, 1.6, 1.3]}
sensors:
  - {name: front, rate_hz: 15}
hands:
  - name: passer
    waypoints:
      - {time_s: 6.4, tips_m: [0.5, 1, 1.25], elbow_m: [0.4, 1.4, 1.4]}
      - {time_s: 7.4, tips_m: [0.6, 0.2, 1.15], elbow_m: [0.5, 0.6, 1.35]}
      - {time_s: 8.4, tips_m: [0.5, 0.5, 1.25], elbow_m: [0.4, 0.9, 1.4]}
      - {time_s: 9.4, tips_m: [0.6, 0.2, 1.15], elbow_m: [0.5, 0.6, 1.35]}
      - {time_s: 10.4, tips_m: [0.5, 0.5, 1.25], elbow_m: [0.4, 0.9, 1.4]}
      - {time_s: 11.4, tips_m: [0.5, 1, 1.25], elbow_m: [0.4, 1.4, 1.4]}
events:
  - carry: {object: soup, robot: arm, link: gripper, from_s: 5.8, to_s: 13.6}
`;

interface TrueFrame { time: number; objects: { name: string; pose: number[] }[]; }

interface ListedSensor { processed_count?: string; processedCount?: string; }

let browser: Browser;
let server: RunningServer;
let page: OpenedPage;
let folder: string;
let truth: TrueFrame[];

before(async () => {
  browser = await openBrowser();
  server = new RunningServer();
  folder = await server.simulate(script);
  truth = readFileSync(join(folder, "front", "truth.jsonl"), "utf8").trim().split("\n").map((line) => JSON.parse(line) as TrueFrame);
  await server.start();
  await server.cwm("robot", "load", arm, "--at", base_m);
  page = await OpenedPage.open(browser, server.url);
});

after(async () => {
  await page.close();
  await browser.close();
  await server.close();
});

const facts = (): ReturnType<OpenedPage["facts"]> => page.facts();

const processed = async (): Promise<number> => {
  const { sensors } = JSON.parse(await server.cwm("call", "ListSensors")) as { sensors: ListedSensor[] };
  return Number(sensors[0]?.processed_count ?? sensors[0]?.processedCount ?? NaN);
};

const middleOf = ({ low, high }: DrawnObject): number[] => low.map((value, i) => (value + (high[i] ?? NaN)) / 2);

const halfCan_m = 0.055;  // its pose is that of its foot, and it stays upright

// How far the middle of the nearest thing drawn is from where the can truly is at that time; `kinds`
// counts: in the gripper it may be a piece that moves, without a name.
async function canError_m(time_s: number, kinds: readonly string[] = ["object"]): Promise<number> {
  const frame = truth.find(({ time }) => time >= time_s) ?? truth.at(-1);
  const [x = NaN, y = NaN, z = NaN] = frame?.objects.find(({ name }) => name === "soup")?.pose ?? [];
  const middle = [x, y, z + halfCan_m];
  const away = (await page.objects()).filter(({ kind }) => kinds.includes(kind)).map((drawn) =>
    Math.hypot(...middleOf(drawn).map((value, i) => value - (middle[i] ?? NaN))));
  return Math.min(...away);
}

const robotReach = async (): Promise<number[]> => {
  const robot = (await page.objects()).find(({ kind }) => kind === "robot");
  return [...(robot?.low ?? []), ...(robot?.high ?? [])];
};

const apart = (a: readonly number[], b: readonly number[]): number => Math.max(...a.map((value, i) => Math.abs(value - (b[i] ?? NaN))));

const movers = async (): Promise<number> => (await page.objects()).filter(({ kind }) => kind === "mover").length;

// The largest share of pixels that the legend has told for a class.
async function shareOf(name: string): Promise<number> {
  const text = await page.page.textContent(`.class:has-text("${name}") .share`) ?? "";
  return Number(text.replace(" %", ""));
}

const setHidden = (isHidden: boolean): Promise<void> => page.page.evaluate((hidden) => {
  Object.defineProperty(document, "hidden", { value: hidden, configurable: true });
  document.dispatchEvent(new Event("visibilitychange"));
}, isHidden);

test("the page follows an arm that carries a can while a hand passes by, and slows no frame", async () => {
  const began_ms = Date.now();
  const streamed = server.cwm("stream", join(folder, "front"), "--realtime");
  const at = (time_s: number): Promise<void> => pause(Math.max(0, began_ms + 1000 * time_s - Date.now()));
  await until("the sensor was listed", () => page.page.isVisible(".sensors .stream.streaming"));
  assert.match(await page.page.textContent(".stream") ?? "", /front.*\/s.*dropped/);
  await page.page.keyboard.press("v");
  await until("its points were shown", async () => (await facts()).live_points > 5000);
  await until("most pixels were as expected", async () => await shareOf("consistent") > 50);
  await until("the can was found", async () => await canError_m(0) < 0.03);
  const stood = await robotReach();

  await at(still_s);
  const before = { processed: await processed(), ms: Date.now() };
  await until("the can was held where the gripper is", async () => await canError_m(holds_s, ["object", "mover", "residual"]) < 0.08);
  assert.ok(apart(stood, await robotReach()) > 0.1, "the arm stands where it is now");
  assert.ok(await shareOf("robot") > 1, "its points are told apart");
  await until("the hand was shown", async () => await movers() > 0);
  await page.keepSmall("viewer-live");
  await page.keep("live");

  await at(rests_s);
  const usual_hz = 1000 * (await processed() - before.processed) / (Date.now() - before.ms);
  await until("the arm stood as it does", async () => apart(stood, await robotReach()) < 0.005);
  // The page is busy for two seconds: frames go on, and at most one of them waits for it.
  const busy = { processed: await processed(), ms: Date.now() };
  const waited = await page.page.evaluate(async () => {
    const { live_frames } = window.cwmViewer.facts();
    for (const end = performance.now() + 2000; performance.now() < end;) ;
    await new Promise((resolve) => setTimeout(resolve, 0));
    return window.cwmViewer.facts().live_frames - live_frames;
  });
  const busy_hz = 1000 * (await processed() - busy.processed) / (Date.now() - busy.ms);
  assert.ok(busy_hz > 0.7 * usual_hz, `${busy_hz} frames a second while the page is busy, ${usual_hz} before`);
  assert.ok(waited <= 1, `${waited} frames queued up`);

  await setHidden(true);
  const hidden = (await facts()).live_frames;
  await pause(700);
  assert.equal((await facts()).live_frames, hidden, "nobody looks");
  await setHidden(false);
  await until("points came again", async () => (await facts()).live_frames > hidden);
  await until("the picture's age was told", async () => (await facts()).picture_latency !== null);

  await streamed;
  await until("the sensor had stopped", async () => /stopped/.test(await page.page.textContent(".stream") ?? ""));
  await until("the movers were gone", async () => await movers() === 0);
  await until("the can was found where it was put", async () => await canError_m(duration_s) < 0.03);
  await page.keep("live-end");
  assert.deepEqual(page.complaints, []);
});
