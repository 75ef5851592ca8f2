// Whether a connection is dead though nobody said so: a watch says something every few seconds, and where the network is gone
// neither side hears of it for minutes. Pure.

// Three bookmarks of a watch that has nothing else to say.
const patience_ms = 15_000;
const longest_ms = 120_000;

export class Silence {
  private allowed_ms = patience_ms;
  private begun_ms = 0;
  private heard_ms = 0;

  opened(now_ms: number): void { this.begun_ms = this.heard_ms = now_ms; }

  // Something came, or something was asked after a time in which nothing had to come. A connection that outlived the patience
  // is a good one, and the next is judged as the first was.
  heard(now_ms: number): void {
    this.heard_ms = now_ms;
    if (now_ms - this.begun_ms > this.allowed_ms) this.allowed_ms = patience_ms;
  }

  // Messages come whole: on a line so slow that one takes longer than this, connecting anew would only begin it again, so that
  // each further time is given twice as long.
  isOver(now_ms: number): boolean {
    if (now_ms - this.heard_ms <= this.allowed_ms) return false;
    this.allowed_ms = Math.min(2 * this.allowed_ms, longest_ms);
    return true;
  }
}
