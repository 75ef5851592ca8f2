// Text beside places of the world, as elements over the picture: it stays sharp, and none of it is
// markup. The CSS2DRenderer of three.js shows labels that overlap and places them between pixels,
// so they are chosen and placed here.
import { Vector3, type Camera } from "three";
import { element } from "../../page/dom";

export interface Label { text: string; at: Vector3; kind: "name" | "mark"; }

// The picture in CSS pixels, and how much of its bottom panels cover.
export interface LabelSpace { width: number; height: number; covered: number; }

// More would cover the picture; the nearest are the readable ones.
const most = 150;

// The approximate size of a label: one that would overlap an earlier one is omitted. The label is
// above its place.
const height_px = 22;
const perLetter_px = { name: 6.6, mark: 7.6 };  // marks are bold
const padding_px = 16;
const widest_px = 240;
const above_px = 29;
const margin_px = 4;

// A mark whose place is taken is put above or below.
const markShifts_px = [0, 1, -1, 2, -2].map((lines) => lines * height_px);

export interface Spot { label: Label; x: number; y: number; width: number; }

const overlap = (a: Spot, b: Spot): boolean =>
  Math.abs(a.x - b.x) < (a.width + b.width) / 2 && Math.abs(a.y - b.y) < height_px;

// The spot moved as little as possible so that the whole label is in the uncovered picture.
function inside(spot: Spot, { width, height, covered }: LabelSpace): Spot {
  const [low, high] = [spot.width / 2 + margin_px, width - spot.width / 2 - margin_px];
  return { ...spot, x: Math.round(Math.max(Math.min(spot.x, high), low)),
           y: Math.round(Math.max(Math.min(spot.y, height - covered - margin_px), above_px + margin_px)) };
}

// The marks in their order, of which the first is always there, at the border if its place is not in
// the picture; then names, the nearest first.
export function spotsOf(labels: readonly Label[], camera: Camera, space: LabelSpace): Spot[] {
  const { width, height, covered } = space;
  const seen = labels.map((label) => {
    const depth = label.at.clone().applyMatrix4(camera.matrixWorldInverse).z;
    const at = label.at.clone().project(camera);
    if (depth > 0) at.negate();  // behind the camera: the border on its own side
    return { label, at, isSeen: depth < 0 && at.z < 1 && Math.abs(at.x) < 1 && Math.abs(at.y) < 1 };
  });
  const marks = seen.filter(({ label }) => label.kind === "mark");
  const names = seen.filter(({ label }) => label.kind === "name").sort((a, b) => a.at.z - b.at.z);
  const free: Spot[] = [];
  for (const { label, at, isSeen } of [...marks, ...names]) {
    if (free.length === most) break;
    const isFirstMark = label === marks[0]?.label;
    if (!isSeen && !isFirstMark) continue;
    const spot = { label, x: Math.round(((at.x + 1) / 2) * width), y: Math.round(((1 - at.y) / 2) * height),
                   width: Math.min(padding_px + perLetter_px[label.kind] * label.text.length, widest_px) };
    const wanted = isFirstMark ? inside(spot, space) : spot;
    const shifts_px = label.kind === "mark" ? markShifts_px : [0];
    const placed = shifts_px.map((shift_px) => ({ ...wanted, y: wanted.y + shift_px }))
      .find((one) => (isFirstMark || one.y <= height - covered) && !free.some((other) => overlap(other, one)));
    if (placed) free.push(placed);
  }
  return free;
}

export class Labels {
  readonly root = element("div", "labels");
  covered_px = 0;  // by panels at the bottom of the picture
  private readonly pool: HTMLElement[] = [];
  private labels: readonly Label[] = [];

  constructor() { this.root.setAttribute("aria-hidden", "true"); }

  set(labels: readonly Label[]): void { this.labels = labels; }

  place(camera: Camera, width: number, height: number): void {
    const seen = spotsOf(this.labels, camera, { width, height, covered: this.covered_px });
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
