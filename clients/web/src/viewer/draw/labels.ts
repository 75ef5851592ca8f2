// Words beside places of the world, as elements over the picture: they stay sharp, and nothing in them is markup.
import { Vector3, type Camera } from "three";
import { element } from "../../page/dom";

export interface Label { text: string; at: Vector3; kind: "name" | "mark"; }

// More would cover the picture; the nearest are the readable ones.
const most = 150;

export class Labels {
  readonly root = element("div", "labels");
  private readonly pool: HTMLElement[] = [];
  private labels: readonly Label[] = [];

  constructor() { this.root.setAttribute("aria-hidden", "true"); }

  set(labels: readonly Label[]): void { this.labels = labels; }

  place(camera: Camera, width_px: number, height_px: number): void {
    const seen = this.labels.map((label) => ({ label, at: label.at.clone().project(camera) }))
      .filter(({ at }) => at.z < 1 && Math.abs(at.x) < 1 && Math.abs(at.y) < 1)
      .sort((a, b) => a.at.z - b.at.z).slice(0, most);
    while (this.pool.length < seen.length) this.pool.push(this.root.appendChild(element("span")));
    this.pool.forEach((span, i) => {
      const one = seen[i];
      span.hidden = one === undefined;
      if (!one) return;
      span.className = `label ${one.label.kind}`;
      if (span.textContent !== one.label.text) span.textContent = one.label.text;
      const x = Math.round(((one.at.x + 1) / 2) * width_px);
      const y = Math.round(((1 - one.at.y) / 2) * height_px);
      span.style.transform = `translate(${x}px, ${y}px) translate(-50%, -130%)`;
    });
  }
}
