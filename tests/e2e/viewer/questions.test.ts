// Questions typed into the page as on the command line, and what the picture shows of the answers.
import assert from "node:assert/strict";
import { after, afterEach, before, beforeEach, test } from "node:test";
import type { Browser } from "playwright-core";
import { openBrowser, OpenedPage } from "./opened_page";
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

const narrow = { width: 400, height: 800 };

const open = async (viewport = { width: 1280, height: 800 }, query = ""): Promise<void> => {
  page = await OpenedPage.open(browser, server.url + query, { viewport });
};

interface Rectangle { x: number; y: number; width: number; height: number; }

const rectangle = async (selector: string): Promise<Rectangle> =>
  await (await page.page.waitForSelector(selector)).boundingBox() ?? assert.fail(`${selector} has no place`);

const overlap = (a: Rectangle, b: Rectangle): boolean =>
  a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;

const marks = (): Promise<(string | null)[]> =>
  page.page.$$eval(".label.mark:not([hidden])", (all) => all.map(({ textContent }) => textContent));

test("a place by an object's name is the command line's", async () => {
  await server.cwm("put", "crate", "--box", "0.2,0.2,0.2", "--at", "0.5,0,0.5");
  await server.cwm("put", "shelf", "--box", "0.4,1,0.03", "--at", "1.5,0,0.7");
  await open();
  await page.settle(2);
  for (const words of [["distance", "--box", "0.1,0.2,0.06", "--at", "crate+0,0,0.20"], ["sample", "crate+0,0,0.25"],
                       ["distance", "--object", "crate", "--at", "shelf+-0.5,0,0"]]) {
    const [row = {}] = ((await server.json(...words))["rows"] ?? []) as { distance_m?: number; answers?: { distance_m: number }[] }[];
    const distance_m = row.distance_m ?? row.answers?.[0]?.distance_m ?? NaN;
    assert.match(await page.query(`cwm ${words.join(" ")}`), new RegExp(`${(1000 * distance_m).toFixed(2)} mm`), words.join(" "));
  }
  const text = await page.query("motion sphere 0.05 at crate+-0.5,0,0 at crate+0.5,0,0");
  assert.match(text, /Meets crate at 35\.0 % of segment 0/);  // 0.5 - 0.1 - 0.05 of a metre
  await until("the crate was marked", async () => (await marks()).join() === "crate");
});

// The boom swings in the plane of the base; folded by pi it lies across the mast.
const urdf = `<robot name="crane">
<link name="base"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
<link name="mast"><collision><origin xyz="0.5 0 0"/><geometry><box size="0.9 0.1 0.1"/></geometry></collision></link>
<link name="boom"><collision><origin xyz="0.6 0 0"/><geometry><box size="1 0.1 0.1"/></geometry></collision></link>
<joint name="lift" type="revolute"><parent link="base"/><child link="mast"/><axis xyz="0 1 0"/><limit lower="-3.2" upper="3.2"/></joint>
<joint name="fold" type="revolute"><parent link="mast"/><child link="boom"/><origin xyz="1.1 0 0"/><axis xyz="0 0 1"/>
<limit lower="-3.2" upper="3.2"/></joint></robot>`;

test("a robot that collides with itself has both links marked in the state that was asked about", async () => {
  await server.cwm("robot", "load", server.write("crane.urdf", urdf));
  await open();
  await until("the robot was drawn", async () => (await page.objects()).some(({ is_drawn }) => is_drawn));
  assert.match(await page.query("check robot crane"), /Free/);
  assert.deepEqual(await marks(), []);
  const { instances } = await page.facts();
  assert.match(await page.query("check robot crane joints 0,3.14159"), /In collision with itself/);
  await page.settle(1);
  await until("both links were marked", async () => (await marks()).length === 2);
  assert.ok((await marks()).includes("boom"), `${await marks()}`);
  assert.ok((await page.facts()).instances > instances, "the robot is drawn in that state, too");
  assert.match(await page.query("motion robot crane joints 0,0 joints 0,3.14159"), /Meets itself \(.*\) at \d+\.\d % of segment 0/);
  await until("both links were marked where it stops", async () => (await marks()).length === 2);
  await page.keep("self-collision");
});

test("on a narrow screen neither a selected object nor the answer covers the other, and the nearest answer's label is seen", async () => {
  await server.cwm("put", "crate", "--box", "0.2,0.2,0.2", "--at", "0.5,0,0.5");
  for (const i of [1, 2, 3]) await server.cwm("put", `can_${i}`, "--cylinder", "0.04,0.12", "--at", `0.5,${0.1 * i},0.75`);
  await open(narrow);
  await page.settle(4);
  await page.page.click(".menu");
  await page.page.getByText("crate", { exact: true }).click();
  const text = await page.query("distance sphere 0.02 at crate+0,0,0.3 max-results 4");
  await page.settle(4);
  const [details, answer, line] = [await rectangle(".side.right"), await rectangle(".answer"), await rectangle(".line")];
  assert.ok(!overlap(details, answer) && !overlap(details, line), "the details cover the answer");
  for (const { x, y, width, height } of [details, answer, line]) {
    assert.ok(x >= 0 && y >= 0 && x + width <= narrow.width && y + height <= narrow.height + 1, "a panel leaves the window");
  }
  const nearest = /([\d.]+ mm) away/.exec(text)?.[1] ?? assert.fail(text);
  const label = await rectangle(`.label.mark:has-text("${nearest}")`);
  assert.ok(!overlap(label, answer) && !overlap(label, details), "a panel covers the nearest answer's label");
  // Wherever the camera looks, the nearest answer's label stays.
  await page.page.focus(".stage");
  for (const key of ["Shift+ArrowLeft", "Shift+ArrowUp", "+"]) {
    for (let i = 0; i < 12; ++i) await page.page.keyboard.press(key);
    await page.settle(4);
    const { x, y, width } = await rectangle(`.label.mark:has-text("${nearest}")`);
    assert.ok(x >= 0 && x + width <= narrow.width && y >= 46, `${key}: the label is at ${x}, ${y}`);
  }
  await page.keep("narrow-answer");
  assert.deepEqual(page.complaints, []);
});

test("the address names the world, and a world without objects is told in words", async () => {
  await server.cwm("put", "ball", "--sphere", "0.1", "--at", "0,0,1");
  await server.cwm("put", "cup", "--sphere", "0.1", "--at", "0,0,1", "--world", "lab_10");
  await server.cwm("put", "can", "--sphere", "0.1", "--at", "0,0,1", "--world", "lab_9");
  await open(undefined, "?world=lab_10");
  await page.settle(1);
  assert.deepEqual(await page.names(), ["cup"]);
  assert.deepEqual(await page.page.$$eval(".toolbar option", (all) => all.map(({ textContent }) => textContent)),
                   ["default", "lab_9", "lab_10"]);
  assert.equal(await page.page.isVisible(".empty"), false);
  await server.cwm("remove", "cup", "--world", "lab_10");
  await page.settle(2);
  assert.match(await page.page.textContent(".empty") ?? "", /\u201clab_10\u201d is empty at revision 2/);
  assert.ok(await page.page.isVisible(".empty"));
  await page.page.selectOption(".toolbar select", "lab_9");
  await until("the other world was shown", async () => (await page.names()).join() === "can");
  assert.equal(await page.page.isVisible(".empty"), false);
  assert.equal(new URL(page.page.url()).searchParams.get("world"), "lab_9");
  await page.page.goto(`${server.url}?world=nowhere`);
  await page.page.waitForFunction(() => "cwmViewer" in window);
  await until("it said that there is no such world", async () =>
    /no world \u201cnowhere\u201d yet/.test(await page.page.textContent(".empty") ?? ""));
  await server.cwm("put", "late", "--sphere", "0.1", "--at", "0,0,1", "--world", "nowhere");
  await until("it appeared", async () => (await page.names()).join() === "late");
  assert.equal(await page.page.isVisible(".empty"), false);
});

interface HiddenBox { box: Record<string, number>; }

test("the space into which a selected object may extend is listed and drawn", async () => {
  await server.ingestKitchen();
  await open();
  await page.settle(1);
  const objects = (await server.json("objects"))["objects"] as { name: string; shapes: { hidden?: HiddenBox }[] }[];
  const found = objects.find(({ name, shapes }) => name.startsWith("object_") && shapes.some(({ hidden }) => hidden));
  assert.ok(found, "nothing of the kitchen has hidden space");
  await page.page.getByText(found.name, { exact: true }).click();
  await page.settle(1);
  const hidden = found.shapes.find((shape) => shape.hidden)?.hidden;
  const sizes = ["size_x_m", "size_y_m", "size_z_m"].map((field) => (1000 * (hidden?.box[field] ?? NaN)).toFixed(1));
  const text = await page.page.textContent(".hidden-space") ?? "";
  assert.match(text, /^Unseen beside it: it may be up to \d+\.\d mm larger/);
  for (const size of sizes) assert.ok(text.includes(size), `${text} has no ${size}`);
  await page.keep("hidden-space");
  const { instances } = await page.facts();
  await page.page.keyboard.press("Escape");
  const without = instances - found.shapes.filter((shape) => shape.hidden).length;
  await until("the space was drawn no more", async () => (await page.facts()).instances === without);
});
