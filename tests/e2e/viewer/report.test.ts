// The page of `cwm report` under a user's hands: all four pictures are turned, zoomed and reset
// together with mouse and keys. Their contents are compared with the world in report_page_test.
import assert from "node:assert/strict";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import type { Browser } from "playwright-core";
import { openBrowser, OpenedPage, type Rgb } from "./opened_page";
import { RunningServer, until } from "./running_server";

type Pixels = (x: number, y: number) => Rgb;

let browser: Browser;
let server: RunningServer;
let opened: OpenedPage;

before(async () => {
  browser = await openBrowser();
  server = new RunningServer();
  await server.start();
  const [scan, page] = [join(server.folder, "kitchen.pcd"), join(server.folder, "kitchen.html")];
  await server.ingestKitchen();
  await server.cwm("report", scan, page);
  opened = await OpenedPage.open(browser, pathToFileURL(page).href,
                                 { viewport: { width: 1000, height: 900 }, isReady: () => document.getElementById("drawn") !== null });
});

after(async () => {
  await opened.close();
  await server.close();
  await browser.close();
});

// The four pictures' places in the window.
const panes = (): Promise<{ x: number; y: number; width: number; height: number }[]> =>
  opened.page.$$eval(".pane .view", (all) => all.map((view) => {
    const { x, y, width, height } = view.getBoundingClientRect();
    return { x, y, width, height };
  }));

// The share of changed pixels per pane, without the axes in the corner.
async function changed(from: Pixels, to: Pixels): Promise<number[]> {
  return (await panes()).map(({ x, y, width, height }) => {
    let [unlike, all] = [0, 0];
    for (let v = y + 60; v < y + height - 10; v += 2) {
      for (let u = x + 70; u < x + width - 10; u += 2) {
        const [a, b] = [from(u, v), to(u, v)];
        unlike += a.some((channel, k) => Math.abs(channel - (b[k] ?? 0)) > 2) ? 1 : 0;
        ++all;
      }
    }
    return unlike / all;
  });
}

// Rounded to a hundredth of a pixel.
const crosses = async (): Promise<string[]> => {
  const all = await opened.page.$$eval(".pane .view svg", (crosses) => crosses.map(({ innerHTML }) => innerHTML));
  return all.map((cross) => cross.replace(/-?\d+\.\d+(e-?\d+)?/g, (number) => String(Math.round(100 * Number(number)) / 100 || 0)));
};

// The window's pixels once nothing moves any more.
async function still(): Promise<Pixels> {
  let before = await opened.pixels();
  let last = before;
  await until("the pictures were still", async () => {
    [before, last] = [last, await opened.pixels()];
    return (await changed(before, last)).every((share) => share === 0);
  });
  return last;
}

async function drag(pane: number, dx: number, dy: number): Promise<void> {
  const { x, y, width, height } = (await panes())[pane] ?? assert.fail("there is no such picture");
  const { mouse } = opened.page;
  await mouse.move(x + width / 2, y + height / 2);
  await mouse.down();
  await mouse.move(x + width / 2 + dx, y + height / 2 + dy, { steps: 5 });
  await mouse.up();
  await mouse.move(2, 2);  // what the pointer is over would be highlighted
}

async function goHome(): Promise<void> {
  await (await opened.page.$(".pane .view"))?.focus();
  await opened.page.keyboard.press("Home");
}

test("a drag in any picture turns all four alike, and Home brings them back", async () => {
  const [home, axes] = [await still(), await crosses()];
  assert.equal(axes.length, 4);
  for (let pane = 0; pane < 4; ++pane) {
    await drag(pane, 80, 25);
    await until("the picture turned", async () => (await crosses())[0] !== axes[0]);
    const now = await crosses();
    assert.deepEqual(now, Array(4).fill(now[0]), "the pictures look from different sides");
    if (pane === 0) {  // looking at pixels takes software seconds
      for (const share of await changed(home, await still())) assert.ok(share > 0.1, `a picture stood still: ${share}`);
      await opened.keep("report-turned");
    }
    await goHome();
    await until("the picture was home", async () => (await crosses())[0] === axes[0]);
  }
  assert.deepEqual(await changed(home, await still()), [0, 0, 0, 0]);
});

test("a turn to the left and one to the right look from different sides, and back is where it was", async () => {
  const home = await still();
  await drag(3, 60, 0);
  const [left, axes] = [await still(), await crosses()];
  await drag(3, -120, 0);
  const right = await still();
  assert.ok((await changed(left, right)).every((share) => share > 0.1));
  await drag(3, 120, 0);
  const back = await still();
  assert.deepEqual(await crosses(), axes);
  assert.ok((await changed(left, back)).every((share) => share < 0.01));
  await goHome();
  assert.deepEqual(await changed(home, await still()), [0, 0, 0, 0]);
});

test("the wheel scrolls the page until a picture has the focus, then zooms all four; arrow keys turn them", async () => {
  const [home, axes] = [await still(), await crosses()];
  const { x, y, width, height } = (await panes())[1] ?? assert.fail("there is no such picture");
  await opened.page.mouse.move(x + width / 2, y + height / 2);
  await opened.page.evaluate(() => (document.activeElement as HTMLElement | null)?.blur());
  await opened.page.mouse.wheel(0, -400);
  await opened.page.mouse.move(2, 2);
  assert.deepEqual(await changed(home, await still()), [0, 0, 0, 0]);
  await (await opened.page.$$(".pane .view"))[1]?.focus();
  await opened.page.mouse.move(x + width / 2, y + height / 2);
  await opened.page.mouse.wheel(0, -400);
  await opened.page.mouse.move(2, 2);
  const zoomed = await changed(home, await still());
  assert.ok(zoomed.every((share) => share > 0.05), `a picture was not zoomed: ${zoomed}`);
  assert.deepEqual(await crosses(), axes);
  await goHome();
  await opened.page.keyboard.press("ArrowLeft");
  assert.ok((await changed(home, await still())).every((share) => share > 0.02));
  assert.notDeepEqual(await crosses(), axes);
  await goHome();
  assert.deepEqual(await changed(home, await still()), [0, 0, 0, 0]);
});

test("the browser has nothing to complain of", () => assert.deepEqual(opened.complaints, []));
