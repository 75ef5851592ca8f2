// The page in a headless Chromium, as a user sees it, and the facts that it reports about itself.
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { chromium, type Browser, type Page } from "playwright-core";
import { until } from "./running_server";

export interface DrawnObject {
  name: string;
  kind: string;
  color: string;
  is_shown: boolean;
  is_drawn: boolean;
  low: number[];
  high: number[];
  x: number;
  y: number;
}

export interface Facts {
  world_uid: string;
  revision: string;
  updates: number;
  first_picture_ms: number;
  last_update_ms: number;
  cloud_points: number;
  live_points: number;
  live_frames: number;
  sensors: number;
  picture_latency: { server_ms: number; way_ms: number; page_ms: number } | null;
  is_live: boolean;
  selected: string;
  grasps: number;
  grippers: number;
  chosen_grasp: number;
  theme: string;
  frames: number;
  is_draft: boolean;
  draw_calls: number;
  instances: number;
  points: number;
  script_times_ms: number[];
}

interface Viewer {
  objects: () => DrawnObject[];
  facts: () => Facts;
  project: (x: number, y: number, z: number) => { x: number; y: number };
  draw: () => void;
}

declare global {
  interface Window { cwmViewer: Viewer; }
}

// The folder for screenshots.
const pictures = process.env["CWM_PICTURES"] ?? "build/pictures";

const executablePath = ["/usr/bin/chromium", "/usr/bin/chromium-browser"].find(existsSync);

export function openBrowser(): Promise<Browser> {
  if (executablePath === undefined) throw new Error("chromium is missing: ./dev setup test installs it");
  return chromium.launch({ executablePath, args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
}

// `isReady` is evaluated in the page; by default it tells whether the viewer runs.
export interface Wishes {
  colorScheme?: "light" | "dark";
  viewport?: { width: number; height: number };
  isReady?: () => boolean;
}

export type Rgb = readonly [number, number, number];

export class OpenedPage {
  readonly complaints: string[] = [];  // of the browser: errors, refusals by the policy

  private constructor(readonly page: Page, private readonly blank: Page) {
    page.on("console", (message) => { if (message.type() === "error") this.complaints.push(message.text()); });
    page.on("pageerror", (error) => this.complaints.push(error.message));
  }

  static async open(browser: Browser, url: string, wishes: Wishes = {}): Promise<OpenedPage> {
    const { colorScheme = "light", viewport = { width: 1280, height: 800 }, isReady = () => "cwmViewer" in window } = wishes;
    const blank = await browser.newPage();  // in front of the other it would have all the frames
    const context = await browser.newContext({ viewport, colorScheme });
    const opened = new OpenedPage(await context.newPage(), blank);
    await opened.page.bringToFront();
    await opened.page.goto(url);
    await opened.page.waitForFunction(isReady);
    return opened;
  }

  async close(): Promise<void> {
    await this.blank.close();
    await this.page.context().close();
  }

  facts(): Promise<Facts> { return this.page.evaluate(() => window.cwmViewer.facts()); }

  objects(): Promise<DrawnObject[]> { return this.page.evaluate(() => window.cwmViewer.objects()); }

  async names(): Promise<string[]> { return (await this.objects()).map(({ name }) => name).sort(); }

  // The position in the window of a point of the world.
  project(x: number, y: number, z: number): Promise<{ x: number; y: number }> {
    return this.page.evaluate(([a = 0, b = 0, c = 0]) => window.cwmViewer.project(a, b, c), [x, y, z]);
  }

  // Waits until the page shows the revision with all meshes and has stopped drawing.
  async settle(revision: number): Promise<void> {
    await until(`the page showed revision ${revision}`, async () => Number((await this.facts()).revision) >= revision);
    await until("everything was drawn", async () => (await this.objects()).every(({ is_drawn, is_shown }) => is_drawn || !is_shown));
    let frames = -1;
    await until("the picture was still", async () => {
      const before = frames;
      const facts = await this.facts();
      frames = facts.frames;
      await this.page.waitForTimeout(150);
      return before === frames && !facts.is_draft;
    });
  }

  // Waits until everything is drawn; with software rendering that takes longer than issuing the
  // commands.
  async finishDrawing(): Promise<void> {
    await this.page.evaluate(() => {
      const gl = document.querySelector("canvas")?.getContext("webgl2");
      gl?.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    });
  }

  // The window's pixels, decoded in a page without a security policy.
  async pixels(): Promise<(x: number, y: number) => Rgb> {
    const png = (await this.page.screenshot()).toString("base64");
    const { width, data } = await this.blank.evaluate(async (text) => {
      const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${text}`)).blob());
      const canvas = new OffscreenCanvas(image.width, image.height);
      const context = canvas.getContext("2d") as OffscreenCanvasRenderingContext2D;
      context.drawImage(image, 0, 0);
      const bytes = context.getImageData(0, 0, image.width, image.height).data;
      let packed = "";
      for (let i = 0; i < bytes.length; i += 1 << 15) packed += String.fromCharCode(...bytes.subarray(i, i + (1 << 15)));
      return { width: image.width, data: btoa(packed) };
    }, png);
    const bytes = Buffer.from(data, "base64");
    return (x, y) => {
      const at = 4 * (Math.round(y) * width + Math.round(x));
      return [bytes[at] ?? 0, bytes[at + 1] ?? 0, bytes[at + 2] ?? 0];
    };
  }

  async keep(name: string): Promise<void> {
    mkdirSync(pictures, { recursive: true });
    await this.page.screenshot({ path: join(pictures, `${name}.png`) });
  }

  // Keeps a small picture for the documentation.
  async keepSmall(name: string): Promise<void> {
    const png = (await this.page.screenshot()).toString("base64");
    const webp = await this.blank.evaluate(async (text) => {
      const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${text}`)).blob());
      const canvas = new OffscreenCanvas(image.width, image.height);
      canvas.getContext("2d")?.drawImage(image, 0, 0);
      const blob = await canvas.convertToBlob({ type: "image/webp", quality: 0.86 });
      const bytes = new Uint8Array(await blob.arrayBuffer());
      let packed = "";
      for (let i = 0; i < bytes.length; i += 1 << 15) packed += String.fromCharCode(...bytes.subarray(i, i + (1 << 15)));
      return btoa(packed);
    }, png);
    mkdirSync(pictures, { recursive: true });
    writeFileSync(join(pictures, `${name}.webp`), new Uint8Array(Buffer.from(webp, "base64")));
  }

  async query(text: string): Promise<string> {
    if (await this.page.isVisible(".answer")) await this.page.click(".answer .close");
    await this.page.fill(".line", text);
    await this.page.press(".line", "Enter");
    await this.page.waitForSelector(".answer:not([hidden])");
    return (await this.page.textContent(".answer")) ?? "";
  }
}

// The hue, 0 to 360; undefined for greys.
export function hue([r, g, b]: Rgb): number | undefined {
  const most = Math.max(r, g, b);
  const chroma = most - Math.min(r, g, b);
  if (chroma < 24) return undefined;
  const sixth = most === r ? ((g - b) / chroma + 6) % 6 : most === g ? (b - r) / chroma + 2 : (r - g) / chroma + 4;
  return 60 * sixth;
}

export const rgbOf = (color: string): Rgb =>
  [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16)) as unknown as Rgb;

// The difference of two hues, 0 to 180; Infinity if one is a grey.
export function hueDifference(a: Rgb, b: Rgb): number {
  const [one, other] = [hue(a), hue(b)];
  if (one === undefined || other === undefined) return Infinity;
  const apart = Math.abs(one - other) % 360;
  return Math.min(apart, 360 - apart);
}
