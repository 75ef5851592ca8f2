// When a picture may be drawn, and how well, by what the ones before cost. Pure.
//
// A picture is begun only after the one before was finished: commands that queue up in a slow
// graphics processor would block the page and show ever older states. While the world moves and a
// picture costs much, as where the processor draws, pictures are drafts; the last one is drawn well.

export type Quality = "full" | "draft";

// chosen: less than ten pictures a second do not look like motion.
const costly_ms = 100;

// chosen: longer than the time between pictures at 10 Hz, as running sensors make them at least.
export const stillTime_ms = 250;

// measured: a full picture costs 3.3 times the processor time of a draft, Chromium drawing in software
// 1 016 x 754 pixels with 20 000 points.
const draftGain = 3.3;

export class FramePacer {
  private begun_ms: number | undefined;  // of the picture being drawn
  private finished_ms = -Infinity;
  private fullCost_ms = 0;
  private quality: Quality = "full";

  get isBusy(): boolean { return this.begun_ms !== undefined; }

  // True if the newest picture is a draft.
  get isDraft(): boolean { return this.quality === "draft"; }

  begin(now_ms: number): Quality {
    const isMoving = now_ms - this.finished_ms < stillTime_ms;
    this.quality = isMoving && this.fullCost_ms > costly_ms ? "draft" : "full";
    this.begun_ms = now_ms;
    return this.quality;
  }

  finish(now_ms: number): void {
    if (this.begun_ms === undefined) return;
    this.fullCost_ms = (now_ms - this.begun_ms) * (this.isDraft ? draftGain : 1);
    this.begun_ms = undefined;
    this.finished_ms = now_ms;
  }
}
