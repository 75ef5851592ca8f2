// The running sensors: how fast, how late, what was lost; the switch of the live points with their
// legend; the age of the picture.
import { element, swatch, withTitle } from "../../page/dom";
import { count } from "../../page/quantity";
import type { PixelCounts, Sensor } from "../../world/stream";
import { pixelClasses, type PixelClass } from "../pixel_classes";
import type { LatencyParts } from "../picture_latency";
import { ageText, calibrationText, latencyParts, latencySum, latencyText, lossText, rateText, shareText } from "../sensor_text";

interface Row { root: HTMLElement; rate: HTMLElement; latency: HTMLElement; losses: HTMLElement; age: HTMLElement; warning: HTMLElement; }

// The classes that points have.
const drawnClasses = pixelClasses.filter(({ key }) => key !== "missing");

function write(where: HTMLElement, text: string): void {
  if (where.textContent !== text) where.textContent = text;
}

export class SensorPanel {
  readonly root = element("section", "sensors");
  private readonly live = element("button", "tool", "Live points");
  private readonly list = element("div", "streams");
  private readonly legend = element("div", "classes");
  private readonly picture = element("p", "picture");
  private readonly rows = new Map<string, Row>();
  private readonly shares = new Map<PixelClass["key"], HTMLElement>();

  constructor(turn: () => void) {
    this.root.setAttribute("aria-label", "Sensors");
    this.live.type = "button";
    this.live.title = "The newest frames' points, in the colours of their classes (v)";
    this.live.addEventListener("click", () => turn());
    for (const { key, color, meaning } of drawnClasses) {
      const share = element("span", "share");
      this.shares.set(key, share);
      this.legend.append(withTitle(element("span", "class", swatch(color), element("span", "", key), share), meaning));
    }
    this.root.append(element("header", "", element("h2", "", "Sensors"), this.live), this.list, this.legend, this.picture);
    this.root.hidden = true;
    this.turn(false);
  }

  // `ages_s`: the time since each sensor's newest frame, by its name.
  show(sensors: readonly Sensor[], ages_s: ReadonlyMap<string, number>): void {
    this.root.hidden = sensors.length === 0;
    const names = new Set(sensors.map(({ name }) => name));
    for (const [name, { root }] of this.rows) {
      if (names.has(name)) continue;
      root.remove();
      this.rows.delete(name);
    }
    for (const sensor of sensors) this.fill(this.rows.get(sensor.name) ?? this.row(sensor.name), sensor, ages_s.get(sensor.name) ?? 0);
  }

  turn(isOn: boolean): void {
    this.live.setAttribute("aria-pressed", String(isOn));
    this.legend.hidden = !isOn;
  }

  // Shares over the newest frames of all sensors.
  showShares(frames: readonly PixelCounts[]): void {
    for (const [key, share] of this.shares) write(share, shareText(key, frames));
  }

  showLatency(parts: LatencyParts | undefined): void {
    this.picture.hidden = parts === undefined;
    if (!parts) return;
    write(this.picture, latencySum(parts));
    this.picture.title = latencyParts(parts);
  }

  private row(name: string): Row {
    const [rate, latency, losses, age, warning] = ["rate", "latency", "losses", "age", "warning"].map((kind) => element("span", kind)) as
      [HTMLElement, HTMLElement, HTMLElement, HTMLElement, HTMLElement];
    const root = element("div", "stream", element("span", "dot"), withTitle(element("span", "text", name), name), rate,
                         element("span", "how", latency, losses, age), warning);
    latency.title = "From the last byte of a frame to its answer: the median of the last seconds, and what 95 of 100 frames take at most";
    age.title = "The time since its newest frame";
    this.list.append(root);
    const row = { root, rate, latency, losses, age, warning };
    this.rows.set(name, row);
    return row;
  }

  private fill({ root, rate, latency, losses, age, warning }: Row, sensor: Sensor, age_s: number): void {
    root.classList.toggle("streaming", sensor.is_streaming);
    write(rate, rateText(sensor));
    write(latency, latencyText(sensor));
    write(losses, lossText(sensor));
    write(age, ageText(age_s));
    write(warning, calibrationText(sensor));
    warning.hidden = warning.textContent === "";
    const mount = sensor.mount ? `on ${sensor.mount.robot}/${sensor.mount.link}, ` : "";
    root.title = `${mount}${count(sensor.processed_count)} frames`;
  }
}
