// Measures the viewer's page with 2 000 objects, and with what moves and a running sensor, and writes
// the figures as JSON into the file that CWM_FIGURES names.
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Browser } from "playwright-core";
import { GrpcCaller } from "../e2e/viewer/grpc_caller";
import { openBrowser, OpenedPage } from "../e2e/viewer/opened_page";
import { pause, RunningServer, until } from "../e2e/viewer/running_server";

const objectCount = 2000;
const turns = 40;
const moves = 9;
const openings = 7;

const shapes = [
  { sphere: { radius_m: 0.1 } }, { box: { size_x_m: 0.2, size_y_m: 0.1, size_z_m: 0.2 } },
  { cylinder: { radius_m: 0.08, length_m: 0.2 } }, { cone: { radius_bottom_m: 0.06, radius_top_m: 0.1, length_m: 0.2 } },
  { capsule: { radius_m: 0.05, length_m: 0.1 } }];

const placeOf = (i: number): object =>
  ({ tx_m: (i % 50) / 3, ty_m: Math.floor(i / 50) / 3, tz_m: 0.2, qx: 0, qy: 0, qz: 0, qw: 1 });

const putAll = (): object[] => Array.from({ length: objectCount }, (_, i) =>
  ({ put: { object: { name: `thing_${i}`, shapes: [shapes[i % shapes.length]], x_world_object: placeOf(i) } } }));

function median(values: readonly number[]): number {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.floor(sorted.length / 2)] ?? NaN;
}

interface FirstPicture { issued_ms: number; finished_ms: number; instances: number; }

// The times from the start of the navigation until the page has issued the drawing of the objects,
// and until they are drawn, for which reading a pixel waits. Every opening has an empty cache of
// its own.
async function firstPicture(browser: Browser, url: string): Promise<FirstPicture> {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 } });
  try {
    const page = await context.newPage();
    await page.addInitScript(() => {
      const look = (): void => {
        const facts = (window as Partial<Window>).cwmViewer?.facts();
        const gl = facts && facts.first_picture_ms > 0 ? document.querySelector("canvas")?.getContext("webgl2") : undefined;
        if (!gl) {
          requestAnimationFrame(look);
          return;
        }
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
        Object.assign(window, { firstPicture: {
          issued_ms: facts?.first_picture_ms, finished_ms: performance.now(), instances: facts?.instances } });
      };
      requestAnimationFrame(look);
    });
    await page.goto(url);
    const found = await page.waitForFunction(() => (window as { firstPicture?: FirstPicture }).firstPicture);
    const picture = await found.jsonValue();
    if (picture?.instances !== objectCount) throw new Error(`the first picture has ${picture?.instances} objects, not ${objectCount}`);
    return picture;
  } finally {
    await context.close();
  }
}

// The camera turns by one key press per frame: each frame is drawn anew when the one before is
// finished.
async function turn(page: OpenedPage): Promise<number[]> {
  await page.page.focus(".stage");
  const times_ms: number[] = [];
  for (let i = 0; i < turns; ++i) {
    await page.finishDrawing();
    const { frames } = await page.facts();
    await page.page.keyboard.press("ArrowLeft");
    await until("it was drawn", async () => (await page.facts()).frames > frames);
    times_ms.push((await page.facts()).script_times_ms.at(-1) ?? NaN);
  }
  return times_ms;
}

// The time from before the call until the page has issued the drawing, once for each move.
async function move(server: RunningServer, page: OpenedPage): Promise<number[]> {
  const times_ms: number[] = [];
  for (let i = 1; i <= moves; ++i) {
    await page.settle(i);
    await page.finishDrawing();
    const began = Date.now();
    await server.cwm("move", "thing_0", "--at", `0,0,${0.2 + 0.01 * i}`);
    await until("the move was drawn", async () => {
      const facts = await page.facts();
      return Number(facts.revision) === 1 + i && facts.last_update_ms >= began;
    });
    times_ms.push((await page.facts()).last_update_ms - began);
  }
  return times_ms;
}

const movingCount = 20;
const moveRate_hz = 30;
const movingTime_ms = 10_000;

// A camera that sees something all over its picture, so that frames have as many points as are shown.
const script = `
scene: kitchen
duration_s: 2
sensors:
  - {name: camera, rate_hz: 10}
`;

const putMoving = (): object[] => Array.from({ length: movingCount }, (_, i) => ({ put: { object: {
  name: `thing_${i}`, shapes: [shapes[i % shapes.length]],
  x_world_object: { tx_m: (i % 5) / 3, ty_m: -3 - Math.floor(i / 5) / 3, tz_m: 0.2, qx: 0, qy: 0, qz: 0, qw: 1 } } } }));

// Moves all things together until the time is over.
async function keepMoving(caller: GrpcCaller): Promise<void> {
  for (const began_ms = Date.now(); Date.now() < began_ms + movingTime_ms; await pause(1000 / moveRate_hz)) {
    const turn_rad = (Date.now() - began_ms) / 1000;
    await caller.applyChanges({ world: "default", changes: Array.from({ length: movingCount }, (_, i) => ({ what: {
      case: "move" as const, value: { name: `thing_${i}`, xWorldObject: {
        txM: (i % 5) / 3, tyM: -3 - Math.floor(i / 5) / 3, tzM: 0.2 + 0.1 * Math.sin(turn_rad + i),
        qz: Math.sin(turn_rad), qw: Math.cos(turn_rad) } } } })) });
  }
}

// 20 objects that move 30 times a second beside 20 000 points of a running sensor, 10 times a second.
async function measureLive(browser: Browser): Promise<object> {
  const server = new RunningServer();
  try {
    const folder = await server.simulate(script);
    await server.start();
    await server.apply(putMoving());
    const page = await OpenedPage.open(browser, server.url);
    await page.settle(1);
    const streamed = server.cwm("stream", join(folder, "camera"), "--realtime", "--quiet", "--loop", "12");
    await until("the sensor was listed", async () => (await page.facts()).sensors === 1);
    await page.page.keyboard.press("v");
    await until("its points were shown", async () => (await page.facts()).live_points > 0);
    const caller = new GrpcCaller(server.socketPath);
    const before = await page.facts();
    await keepMoving(caller);
    const after = await page.facts();
    caller.close();
    const seconds = movingTime_ms / 1000;
    const figures = {
      live_frame_cpu_ms: median(after.script_times_ms), live_pictures_hz: (after.frames - before.frames) / seconds,
      live_updates_hz: (after.updates - before.updates) / seconds, live_frames_hz: (after.live_frames - before.live_frames) / seconds,
      live_points: after.live_points };
    await page.close();
    await streamed;
    return figures;
  } finally {
    await server.close();
  }
}

async function measure(): Promise<object> {
  const browser = await openBrowser();
  try {
    return { ...await measureMany(browser), ...await measureLive(browser) };
  } finally {
    await browser.close();
  }
}

async function measureMany(browser: Browser): Promise<object> {
  const server = new RunningServer();
  try {
    await server.start();
    await server.apply(putAll());
    const first: FirstPicture[] = [];
    for (let i = 0; i < openings; ++i) first.push(await firstPicture(browser, server.url));
    const page = await OpenedPage.open(browser, server.url);
    await page.settle(1);
    const frame_cpu_ms = median(await turn(page));
    const { draw_calls } = await page.facts();
    const update_ms = median(await move(server, page));
    await page.close();
    return { frame_cpu_ms, draw_calls, first_picture_ms: median(first.map(({ issued_ms }) => issued_ms)),
             first_picture_finished_ms: median(first.map(({ finished_ms }) => finished_ms)), update_ms };
  } finally {
    await server.close();
  }
}

measure().then((figures) => writeFileSync(process.env["CWM_FIGURES"] ?? "viewer_figures.json", JSON.stringify(figures)))
  .catch((error: unknown) => {
    console.error(error);
    process.exitCode = 1;
  });
