// A slider over the revisions that the server keeps exactly, and a button back to the present.
import { element } from "../../page/dom";
import { count } from "../../page/quantity";

export interface TimelineListener { go: (revision: number) => void; live: () => void; }

export class Timeline {
  readonly root = element("section", "timeline");
  private readonly slider = element("input");
  private readonly text = element("output", "revision");
  private readonly live = element("button", "live", "Live");
  private oldest = 0;
  private newest = 0;
  private shown: number | undefined;

  constructor(private readonly listener: TimelineListener) {
    this.root.setAttribute("aria-label", "Revisions of the world");
    this.slider.type = "range";
    this.slider.step = "1";
    this.slider.setAttribute("aria-label", "Revision of the world");
    this.slider.addEventListener("input", () => this.move(Number(this.slider.value)));
    this.live.type = "button";
    this.live.title = "Show the world as it is now (l)";
    this.live.addEventListener("click", () => this.goLive());
    this.root.append(this.slider, this.text, this.live);
    this.paint();
  }

  setNewest(newest: number): void {
    this.newest = newest;
    this.oldest = Math.min(this.oldest, newest);
    this.paint();
  }

  setOldest(oldest: number): void {
    this.oldest = Math.min(oldest, this.newest);
    this.paint();
  }

  // A revision that is shown in place of the one that was asked for.
  showPast(revision: number): void {
    this.shown = revision;
    this.paint();
  }

  goLive(): void {
    this.shown = undefined;
    this.paint();
    this.listener.live();
  }

  private move(revision: number): void {
    this.shown = revision >= this.newest ? undefined : revision;
    this.paint();
    if (this.shown === undefined) this.listener.live();
    else this.listener.go(this.shown);
  }

  private paint(): void {
    const at = this.shown ?? this.newest;
    this.slider.min = String(this.oldest);
    this.slider.max = String(this.newest);
    this.slider.value = String(at);
    this.slider.disabled = this.newest <= this.oldest;
    this.slider.style.setProperty("--share", String(this.newest > this.oldest ? (at - this.oldest) / (this.newest - this.oldest) : 1));
    this.text.textContent = `revision ${count(at)}`;
    this.live.setAttribute("aria-pressed", String(this.shown === undefined));
    this.root.classList.toggle("past", this.shown !== undefined);
  }
}
