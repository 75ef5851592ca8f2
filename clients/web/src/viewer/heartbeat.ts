// Detects a dead connection: a watch sends something every few seconds, while a lost network is not
// noticed for minutes. Pure.

// chosen: three bookmarks of an idle watch.
const patience_ms = 15_000;
const longest_ms = 120_000;

export class HeartbeatMonitor {
  private allowed_ms = patience_ms;
  private begun_ms = 0;
  private received_ms = 0;

  opened(now_ms: number): void { this.begun_ms = this.received_ms = now_ms; }

  // Called when something was received, or requested after a time in which nothing was expected. A
  // connection that outlived the limit is good, and the limit is reset.
  received(now_ms: number): void {
    this.received_ms = now_ms;
    if (now_ms - this.begun_ms > this.allowed_ms) this.allowed_ms = patience_ms;
  }

  // Messages arrive as a whole: on a line so slow that a message takes longer than the limit,
  // reconnecting would only start it again, so the limit doubles each time.
  isTimedOut(now_ms: number): boolean {
    if (now_ms - this.received_ms <= this.allowed_ms) return false;
    this.allowed_ms = Math.min(2 * this.allowed_ms, longest_ms);
    return true;
  }
}
