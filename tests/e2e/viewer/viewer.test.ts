// The viewer's page as a user sees it: it must show what the server has.
import assert from "node:assert/strict";
import { after, afterEach, before, beforeEach, test } from "node:test";
import type { Browser } from "playwright-core";
import { hueDifference, hue, openBrowser, OpenedPage, rgbOf, type Rgb } from "./opened_page";
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

const open = async (scheme: "light" | "dark" = "light"): Promise<void> => { page = await OpenedPage.open(browser, server.url, { colorScheme: scheme }); };

interface Listed { name: string; kind: string; }

const listed = async (): Promise<Listed[]> => (await server.json("objects"))["objects"] as Listed[];

const revision = async (): Promise<number> => Number((await server.json("objects"))["revision"]);

// Lighting changes a colour's brightness, but little of its hue.
const sameHue_deg = 14;

function assertHue(actual: Rgb, color: string, what: string): void {
  assert.ok(hueDifference(actual, rgbOf(color)) < sameHue_deg, `${what}: rgb(${actual}) is not of ${color}`);
}

function assertGround(actual: Rgb, what: string): void {
  assert.equal(hue(actual), undefined, `${what}: rgb(${actual}) is not the ground's`);
}

test("every object that the server lists is there, in the list and in the picture", async () => {
  await server.ingestKitchen();
  await server.cwm("put", "crate", "--box", "0.15,0.2,0.16", "--at", "0.5,-0.55,0.98");
  await open();
  await page.settle(await revision());
  const all = await listed();
  assert.ok(all.length >= 10, "eight things on a counter, and the counter");
  assert.deepEqual(await page.names(), all.map(({ name }) => name).sort());
  const rows = await page.page.$$eval(".leaf .text", (spans) => spans.map(({ textContent }) => textContent));
  assert.deepEqual(rows.sort(), all.map(({ name }) => name).sort());
  const kindOf = new Map((await page.objects()).map(({ name, kind }) => [name, kind]));
  for (const { name, kind } of all) assert.equal(kindOf.get(name), kind.replace("OBJECT_KIND_", "").toLowerCase());
  const { scans } = JSON.parse(await server.cwm("call", "ListScans")) as { scans: { keptCount?: string; kept_count?: string }[] };
  await until("the scan was shown", async () => (await page.facts()).cloud_points > 0);
  assert.equal((await page.facts()).cloud_points, Number(scans[0]?.kept_count ?? scans[0]?.keptCount));
  await page.keepSmall("viewer-kitchen");
  await page.page.keyboard.press("p");  // the model alone
  await page.page.getByText("object_1", { exact: true }).click();
  assert.match(await page.query("distance sphere 0.05 at 0.35 -0.1 1.25 max-results 2"), /away/);
  await page.settle(2);
  await page.keepSmall("viewer-question");
  // The object is seen again and nothing else changes; the page must still report it.
  const lastSeen = async (): Promise<string> => /Last seen(.*?UTC)/.exec(await page.page.textContent(".details") ?? "")?.[1] ?? "";
  const before = await lastSeen();
  assert.notEqual(before, "");
  await server.ingestKitchen();
  await until("the sighting was told", async () => await lastSeen() !== before);
  assert.deepEqual(page.complaints, []);
});

// Objects side by side along x at y = 0; each extends `half` to either side of its middle when seen
// from -y.
const row = [
  { name: "ball", half: 0.1, shape: { sphere: { radius_m: 0.1 } } },
  { name: "block", half: 0.1, shape: { box: { size_x_m: 0.2, size_y_m: 0.1, size_z_m: 0.2 } } },
  { name: "can", half: 0.08, shape: { cylinder: { radius_m: 0.08, length_m: 0.2 } } },
  { name: "cup", half: 0.08, shape: { cone: { radius_bottom_m: 0.06, radius_top_m: 0.1, length_m: 0.2 } } },
  { name: "pill", half: 0.05, shape: { capsule: { radius_m: 0.05, length_m: 0.1 } } },
];
const spacing_m = 0.4;

test("each kind of shape is where it is, as wide as it is, in its colour, and nothing is beside it", async () => {
  await server.apply(row.map(({ name, shape }, i) => ({ put: { object: {
    name, shapes: [shape], x_world_object: { tx_m: spacing_m * i, ty_m: 0, tz_m: 0.5, qx: 0, qy: 0, qz: 0, qw: 1 } } } })));
  await open();
  await page.settle(1);
  await page.page.keyboard.press("4");
  await page.settle(1);
  const pixels = await page.pixels();
  const colors = new Map((await page.objects()).map(({ name, color }) => [name, color]));
  assert.equal(new Set(colors.values()).size, row.length);
  for (const [i, { name, half }] of row.entries()) {
    for (const [share, isInside] of [[0, true], [0.85, true], [-0.85, true], [1.35, false], [-1.35, false]] as const) {
      const { x, y } = await page.project(spacing_m * i + share * half, 0, 0.5);
      const what = `${name} at ${share} of its half width`;
      if (isInside) assertHue(pixels(x, y), colors.get(name) ?? "", what);
      else assertGround(pixels(x, y), what);
    }
  }
  // The cone is wide at the top and narrow at the bottom: between its two radii only the top is
  // visible.
  const cup = row.findIndex(({ name }) => name === "cup");
  const above = await page.project(spacing_m * cup + 0.085, 0, 0.58);
  const below = await page.project(spacing_m * cup + 0.085, 0, 0.42);
  assertHue(pixels(above.x, above.y), colors.get("cup") ?? "", "the cup's rim");
  assertGround(pixels(below.x, below.y), "beside the cup's foot");
  await page.keep("shapes");
});

test("a change shows within 200 ms", async () => {
  await server.cwm("put", "crate", "--box", "0.2,0.2,0.2", "--at", "0,0,0.1");
  await open();
  await page.settle(1);
  const times_ms: number[] = [];
  for (let i = 1; i <= 7; ++i) {
    await page.settle(i);
    await page.finishDrawing();
    const began = Date.now();
    await server.cwm("move", "crate", "--at", `${0.05 * i},0,0.1`);
    await until("the move was drawn", async () => {
      const facts = await page.facts();
      return Number(facts.revision) === 1 + i && facts.last_update_ms >= began;
    });
    times_ms.push((await page.facts()).last_update_ms - began);
  }
  // The time from starting the command to the drawn picture; the best of several, since the machine
  // has other load.
  assert.ok(Math.min(...times_ms) <= 200, `${times_ms} ms`);
  const crate = (await page.objects())[0];
  assert.ok(crate && Math.abs((crate.low[0] ?? 0) + 0.1 - 0.35) < 1e-5, "it is where it was moved to");
});

test("what is removed goes, however fast things change", async () => {
  await server.cwm("put", "stays", "--sphere", "0.1", "--at", "0,0,1");
  await open();
  await page.settle(1);
  const thing = (i: number): object => ({ put: { object: {
    name: `thing_${i}`, shapes: [{ sphere: { radius_m: 0.05 } }], x_world_object: { tx_m: i / 10, ty_m: 0, tz_m: 0, qx: 0, qy: 0, qz: 0, qw: 1 } } } });
  for (let round = 0; round < 10; ++round) {
    await server.apply(Array.from({ length: 40 }, (_, i) => thing(i)));
    await server.apply(Array.from({ length: 39 }, (_, i) => ({ remove: { name: `thing_${i}` } })));
    await server.apply([{ remove: { name: "thing_39" } }]);
  }
  await server.apply([thing(7)]);
  await page.settle(await revision());
  assert.deepEqual(await page.names(), ["stays", "thing_7"]);
  assert.equal((await page.facts()).instances, 2);
});

test("a restarted server is shown anew, and meanwhile the page says that it has lost it", async () => {
  await server.cwm("put", "old", "--sphere", "0.1", "--at", "0,0,1");
  await open();
  await page.settle(1);
  const { world_uid } = await page.facts();
  const connection = async (): Promise<string> => await page.page.textContent(".connection") ?? "";
  server.freeze();
  await until("the page noticed the silence", async () => /silent/.test(await connection()));
  server.goOn();
  await until("it was connected again", async () => await connection() === "Connected");
  await server.cwm("move", "old", "--at", "0,0,2");
  await page.settle(2);
  await server.stop();
  await page.page.waitForFunction(() => document.querySelector(".dot.open") === null);
  assert.match(await connection(), /No connection|Connecting/);
  await server.start();
  await server.cwm("put", "new", "--sphere", "0.1", "--at", "0,0,1");
  await until("the new world was shown", async () => (await page.names()).join() === "new");
  assert.notEqual((await page.facts()).world_uid, world_uid);
  assert.equal(await connection(), "Connected");
  await server.stop();
  await server.start("a-token-of-the-user");
  await until("the refusal was said", async () => /^Refused: token: is absent; open the address/.test(await connection()));
  assert.match(await page.page.textContent(".notices") ?? "", /token: is absent/);
  await page.keep("refused");
  let attempts = 0;
  page.page.on("request", () => { ++attempts; });
  await page.page.waitForTimeout(1500);
  assert.equal(attempts, 0, "what is refused is not asked for again");
  await server.cwm("put", "third", "--sphere", "0.1", "--at", "0,0,1");
  await page.page.goto(server.url);
  await page.page.waitForFunction(() => "cwmViewer" in window);
  await until("the world was shown to who has the token", async () => (await page.names()).join() === "third");
});

test("two thousand objects cost a few draw calls", async () => {
  const shapes = row.map(({ shape }) => shape);
  await server.apply(Array.from({ length: 2000 }, (_, i) => ({ put: { object: {
    name: `thing_${i}`, shapes: [shapes[i % shapes.length]],
    x_world_object: { tx_m: (i % 50) / 3, ty_m: Math.floor(i / 50) / 3, tz_m: 0.2, qx: 0, qy: 0, qz: 0, qw: 1 } } } })));
  await open();
  await page.settle(1);
  const facts = await page.facts();
  assert.equal((await page.objects()).length, 2000);
  assert.equal(facts.instances, 2000);
  // Boxes; cylinders and cones; spheres and capsules; the floor; the axes.
  assert.ok(facts.draw_calls <= 5, `${facts.draw_calls} draw calls`);
  await page.keep("two-thousand");
});

test("a question is answered as the command line answers it, and drawn", async () => {
  await server.cwm("put", "crate", "--box", "0.2,0.2,0.2", "--at", "0.5,0,0.5");
  await open();
  await page.settle(1);
  const text = await page.query("distance sphere 0.05 at 0.5 0 1");
  assert.match(text, /350\.00 mm away/);
  assert.match(text, /crate/);
  assert.match(text, /exact/);
  assert.match(await page.query("contacts sphere 0.05 at 0.5 0 0.62"), /1 contact, deepest 30\.00 mm/);
  assert.match(await page.query("check box 0.1 0.1 0.1 at 0.5 0 0.6"), /In collision with crate/);
  assert.match(await page.query("ray from 0.5 0 2 direction 0 0 -1"), /Hits crate after 1400\.00 mm/);
  await page.keep("question");
  assert.match(await page.query("distance object nobody"), /OBJECT_UNKNOWN|nobody/);
  assert.match(await page.query("distance sphere -1 at 0 0 0"), /radius_m/, "the field that the server names");
  assert.match(await page.query("how far is it"), /begins with distance, contacts, check, motion, ray or sample/);
  // The answer's panel is closed before the next answer: in one task, so that no answer comes
  // between.
  await page.page.click(".answer .close");
  await page.page.fill(".line", "distance sphere 0.05 at 0.5 0 1");
  await page.page.focus(".line");
  await page.page.$eval(".line", (line) => {
    for (const key of ["Enter", "Escape"]) line.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
  });
  await page.page.waitForTimeout(500);
  assert.equal(await page.page.isVisible(".answer"), false);
});

test("a click tells what was hit, and an older revision can be looked at", async () => {
  await server.cwm("put", "crate", "--box", "0.2,0.2,0.2", "--at", "0,0,0.5", "--margin", "0.01");
  await server.cwm("put", "ball", "--sphere", "0.1", "--at", "0.6,0,0.5");
  await open();
  await page.settle(2);
  const { x, y } = await page.project(0, 0, 0.5);
  await page.page.mouse.click(x, y);
  await page.page.waitForSelector(".details:not([hidden])");
  const details = await page.page.textContent(".details") ?? "";
  for (const word of [/crate/, /user/, /0\.000\s*0\.000\s*0\.500/, /200\.0/, /Margin10\.0 mm/]) assert.match(details, word);
  // The focus on a button of the details stays there while the world changes.
  await page.page.focus(".details header button");
  await server.cwm("move", "ball", "--at", "0.7,0,0.5");
  await server.cwm("allow", "crate", "ball");
  await server.cwm("move", "crate", "--at", "0,0,0.6");
  await page.settle(5);
  assert.match(await page.page.textContent(".details") ?? "", /0\.600.*may touch ball/);
  assert.equal(await page.page.evaluate(() => document.activeElement?.textContent), "Frame");
  // The rules of the displayed revision, not of the latest.
  for (const [revision, isRuled] of [["3", false], ["4", true], ["2", false]] as const) {
    await page.page.fill(".timeline input", revision);
    await until(`revision ${revision} was shown`, async () => (await page.facts()).revision === revision);
    assert.equal(/may touch ball/.test(await page.page.textContent(".details") ?? ""), isRuled, revision);
  }
  await page.page.click(".live");
  await page.page.keyboard.press("Escape");
  assert.equal((await page.facts()).selected, "");
  await page.page.fill(".timeline input", "1");
  await until("revision 1 was shown", async () => (await page.facts()).revision === "1");
  assert.deepEqual(await page.names(), ["crate"]);
  await page.page.click(".live");
  await until("the newest was shown", async () => (await page.facts()).revision === "5");
  assert.deepEqual(await page.names(), ["ball", "crate"]);
});

test("what is unticked is not drawn, and the keys find what they promise", async () => {
  await server.cwm("put", "crate", "--box", "0.2,0.2,0.2", "--at", "0,0,0.5");
  await server.cwm("put", "ball", "--sphere", "0.1", "--at", "0.6,0,0.5");
  await open();
  await page.settle(2);
  const { x, y } = await page.project(0, 0, 0.5);
  assertHue((await page.pixels())(x, y), (await page.objects()).find(({ name }) => name === "crate")?.color ?? "", "crate");
  await page.page.getByLabel("Show crate").click();
  await page.settle(2);
  assertGround((await page.pixels())(x, y), "where the crate was");
  // A new object with the name of a removed, hidden one is not hidden.
  await server.cwm("remove", "crate");
  await page.settle(3);
  await server.cwm("put", "crate", "--box", "0.2,0.2,0.2", "--at", "0,0,0.5");
  await page.settle(4);
  assert.ok((await page.objects()).every(({ is_shown }) => is_shown));
  assert.ok(await page.page.getByLabel("Show crate").isChecked());
  // The tree is one tab stop; arrow keys move within it.
  const stops = (): Promise<(string | null)[]> =>
    page.page.$$eval(".tree [tabindex='0']", (all) => all.map(({ textContent }) => textContent));
  assert.equal((await stops()).length, 1);
  await page.page.focus(".search");
  await page.page.keyboard.press("Tab");
  const focused = (): Promise<string> => page.page.evaluate(() => document.activeElement?.textContent ?? "");
  assert.match(await focused(), /^User's objects/);
  await page.page.keyboard.press("ArrowDown");
  await page.page.keyboard.press("ArrowDown");
  assert.equal(await focused(), "crate");
  assert.deepEqual(await stops(), ["crate"]);
  await page.page.keyboard.press("ArrowLeft");
  await page.page.keyboard.press("ArrowLeft");
  assert.deepEqual(await stops(), [await focused()]);
  await page.page.keyboard.press("ArrowRight");
  // The focus stays on its row when other rows are added, and in the tree when its row is removed.
  await page.page.keyboard.press("ArrowDown");
  assert.equal(await focused(), "ball");
  await server.cwm("put", "apple", "--sphere", "0.1", "--at", "1.2,0,0.5");
  await page.settle(5);
  assert.equal(await focused(), "ball");
  await server.cwm("remove", "apple");
  await page.page.keyboard.press("End");
  assert.equal(await focused(), "crate");
  await server.cwm("move", "ball", "--at", "0.6,0,0.6");
  await page.settle(7);
  assert.deepEqual(await stops(), ["crate"]);
  await page.page.keyboard.press("Escape");
  await page.page.keyboard.press("/");
  await page.page.keyboard.type("bal");
  assert.deepEqual(await page.page.$$eval(".leaf .text", (spans) => spans.map(({ textContent }) => textContent)), ["ball"]);
  await page.page.keyboard.press("Enter");
  assert.equal((await page.facts()).selected, "ball");
  await page.page.keyboard.press("Escape");
  await page.page.keyboard.press("Escape");
  await page.page.keyboard.press("?");
  assert.ok(await page.page.isVisible("dialog.help"));
});

test("keys turn, move and zoom the view and go back to the first one", async () => {
  await server.cwm("put", "crate", "--box", "0.2,0.2,0.2", "--at", "0,0,0.5");
  await server.cwm("put", "ball", "--sphere", "0.1", "--at", "0.6,0,0.5");
  await open();
  await page.settle(2);
  // The first picture is drawn anew for some time while more arrives; a key ends that.
  await page.page.focus(".stage");
  await page.page.keyboard.press("1");
  type Place = { x: number; y: number };
  const places = (): Promise<Place[]> => Promise.all([0, 0.6].map((x) => page.project(x, 0, 0.5)));
  const apart = ([a, b]: Place[]): number => Math.hypot((a?.x ?? NaN) - (b?.x ?? NaN), (a?.y ?? NaN) - (b?.y ?? NaN));
  await page.settle(2);
  const first = await places();
  const isFirst = (now: Place[]): boolean =>
    now.every(({ x, y }, i) => Math.hypot(x - (first[i]?.x ?? NaN), y - (first[i]?.y ?? NaN)) < 0.05);
  const press = async (key: string, isRight: (now: Place[]) => boolean): Promise<void> => {
    await page.page.keyboard.press(key);
    await until(`${key} moved the view`, async () => isRight(await places()));
  };
  const [crate = { x: NaN, y: NaN }] = first;
  for (const [key, back, isRight] of [
    ["ArrowLeft", "ArrowRight", (now: Place[]) => apart(now) < 0.98 * apart(first)],
    ["ArrowUp", "ArrowDown", (now: Place[]) => (now[0]?.y ?? NaN) > crate.y + 5],
    ["Shift+ArrowLeft", "Shift+ArrowRight", (now: Place[]) => (now[0]?.x ?? NaN) > crate.x + 20],
    ["Shift+ArrowUp", "Shift+ArrowDown", (now: Place[]) => (now[0]?.y ?? NaN) > crate.y + 20],
    ["+", "-", (now: Place[]) => apart(now) > 1.05 * apart(first)],
  ] as const) {
    await press(key, isRight);
    await press(back, isFirst);
  }
  for (const key of ["ArrowLeft", "Shift+ArrowUp", "+"]) await press(key, (now) => !isFirst(now));
  await press("Home", isFirst);
});

const urdf = `<robot name="crane">
<link name="base"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
<link name="boom"><collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry></collision></link>
<joint name="swing" type="revolute"><parent link="base"/><child link="boom"/><origin xyz="0 0 0.2"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2"/></joint></robot>`;

test("a robot stands where its state puts it, and follows it", async () => {
  await server.cwm("robot", "load", server.write("crane.urdf", urdf));
  await open();
  await until("the robot was drawn", async () => (await page.objects()).some(({ is_drawn }) => is_drawn));
  const reach = async (): Promise<number[]> => (await page.objects())[0]?.high ?? [];
  assert.ok(Math.abs((await reach())[0] as number - 1) < 1e-5, "the boom lies along x");
  await server.apply([{ robot_state: { name: "crane", joints: { values: [{ variable: "swing", value: Math.PI / 2 }] } } }]);
  await until("the boom lay along y", async () => Math.abs((await reach())[1] as number - 1) < 1e-4);
  assert.ok(Math.abs((await reach())[0] as number - 0.1) < 1e-4);
});

test("the page is light or dark as the system is, and remembers what the user chose", async () => {
  await server.ingestKitchen();
  await open("dark");
  await page.settle(1);
  const brightness = async (): Promise<number> => Math.max(...(await page.pixels())(4, 300));
  assert.ok(await brightness() < 60);
  await page.page.keyboard.press("n");
  await page.page.click(".leaf .name");
  await page.settle(1);
  await page.keep("kitchen-dark");
  await page.page.keyboard.press("t");
  assert.ok(await brightness() > 200);
  const { cloud_points } = await page.facts();
  assert.ok(cloud_points > 0);
  // A busy server is asked again until it answers.
  const asked = new Map<string, number>();
  await page.page.route("**/geometry/*", async (route) => {
    const url = route.request().url();
    asked.set(url, (asked.get(url) ?? 0) + 1);
    await ((asked.get(url) ?? 0) <= 4 ? route.fulfill({ status: 503, body: "busy" }) : route.continue());
  });
  await page.page.reload();
  await page.page.waitForFunction(() => "cwmViewer" in window);
  assert.ok(await brightness() > 200);
  await page.settle(1);
  await until("the scan was shown again", async () => (await page.facts()).cloud_points === cloud_points);
  await until("everything else came, too", () => [...asked.values()].every((times) => times === 5));
  assert.ok(asked.size > 2, "points, labels and surfaces");
  assert.equal(await page.page.textContent(".notices"), "");
  await page.page.setViewportSize({ width: 420, height: 800 });
  await page.settle(1);
  await page.keep("narrow");
  assert.deepEqual(page.complaints.filter((text) => !text.includes("503")), []);
});
