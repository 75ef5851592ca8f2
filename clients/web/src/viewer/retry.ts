// Retries operations that may succeed later, with growing delays.
import { CallFailure } from "./link";
import { backOff_ms, resourceExhausted, unavailable } from "./messages";

// A temporary failure other than a call's: the server was busy, or the network down.
export class PassingFailure extends Error {}

export const isPassing = (error: unknown): boolean => error instanceof PassingFailure ||
  (error instanceof CallFailure && [unavailable, resourceExhausted].includes(error.error.code));

const pause = (ms: number): Promise<void> => new Promise((resolve) => setTimeout(resolve, ms));

// Repeats the work until it succeeds, fails for good, or is no longer wanted; then throws its last
// error.
export async function patiently<Result>(work: () => Promise<Result>, isWanted: () => boolean): Promise<Result> {
  for (let attempt = 0; ; ++attempt) {
    try {
      return await work();
    } catch (error) {
      if (!isPassing(error) || !isWanted()) throw error;
      await pause(backOff_ms(attempt));
      if (!isWanted()) throw error;
    }
  }
}

// Runs one operation at a time, and once more if it was requested meanwhile.
export class Latest {
  private isRunning = false;
  private isAsked = false;
  constructor(private readonly work: () => Promise<void>) {}

  want(): void {
    this.isAsked = true;
    if (!this.isRunning) void this.run();
  }

  private async run(): Promise<void> {
    this.isRunning = true;
    try {
      while (this.isAsked) {
        this.isAsked = false;
        await this.work();
      }
    } finally {
      this.isRunning = false;
    }
  }
}

// Uses only the answer to the newest of successive requests.
export class Newest {
  private last = 0;
  private isOpen = false;

  // Returns a function that tells whether this request is still the newest.
  begin(): () => boolean {
    const own = ++this.last;
    this.isOpen = true;
    return () => own === this.last;
  }

  // Drops all requests made so far.
  drop(): void {
    ++this.last;
    this.isOpen = false;
  }

  // True if a request is pending that was not dropped.
  get isPending(): boolean { return this.isOpen; }
}
