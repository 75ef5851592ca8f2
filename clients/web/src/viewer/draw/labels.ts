// Text beside places of the world, as elements over the picture: it stays sharp, and none of it is
// markup. The CSS2DRenderer of three.js shows labels that overlap and places them between pixels,
// so they are chosen and placed here.
import { Vector3, type Camera } from "three";
import { element } from "../../page/dom";

export interface Label { text: string; at: Vector3; kind: "name" | "mark"; }

// More would cover the picture; the nearest are the readable ones.
const most = 150;

// The approximate size of a label: one that would overlap a nearer label is omitted.
const height_px = 22;
const perLetter_px = 6.6;
const padding_px = 16;

interface Spot { label: Label; x: number; y: number; width: number; }

const overlap = (a: Spot, b: Spot): boolean =>
  Math.abs(a.x - b.x) < (a.width + b.width) / 2 && Math.abs(a.y - b.y) < height_px;

// Marks before names, then the nearest first.
function spotsOf(labels: readonly Label[], camera: Camera, width: number, height: number): Spot[] {
  const seen = labels.map((label) => ({ label, at: label.at.clone().project(camera) }))
    .filter(({ at }) => at.z < 1 && Math.abs(at.x) < 1 && Math.abs(at.y) < 1)
    .sort((a, b) => Number(a.label.kind === "name") - Number(b.label.kind === "name") || a.at.z - b.at.z);
  const free: Spot[] = [];
  for (const { label, at } of seen) {
    if (free.length === most) break;
    const spot = { label, x: Math.round(((at.x + 1) / 2) * width), y: Math.round(((1 - at.y) / 2) * height),
                   width: padding_px + perLetter_px * label.text.length };
    if (!free.some((other) => overlap(other, spot))) free.push(spot);
  }
  return free;
}

export class Labels {
  readonly root = element("div", "labels");
  private readonly pool: HTMLElement[] = [];
  private labels: readonly Label[] = [];

  constructor() { this.root.setAttribute("aria-hidden", "true"); }

  set(labels: readonly Label[]): void { this.labels = labels; }

  place(camera: Camera, width: number, height: number): void {
    const seen = spotsOf(this.labels, camera, width, height);
    while (this.pool.length < seen.length) this.pool.push(this.root.appendChild(element("span")));
    this.pool.forEach((span, i) => {
      const one = seen[i];
      span.hidden = one === undefined;
      if (!one) return;
      span.className = `label ${one.label.kind}`;
      if (span.textContent !== one.label.text) span.textContent = one.label.text;
      span.style.transform = `translate(${one.x}px, ${one.y}px) translate(-50%, -130%)`;
    });
  }
}
