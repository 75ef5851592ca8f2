// Retries operations that may succeed later, with growing delays.
import { CallFailure } from "./rpc_client";
import { backOff_ms, resourceExhausted, unavailable } from "./messages";

// A temporary failure other than a call's: the server was busy, or the network down.
export class TransientError extends Error {}

export const isTransient = (error: unknown): boolean => error instanceof TransientError ||
  (error instanceof CallFailure && [unavailable, resourceExhausted].includes(error.error.code));

const pause = (ms: number): Promise<void> => new Promise((resolve) => setTimeout(resolve, ms));

// Repeats the work until it succeeds, fails for good, or is no longer wanted; then throws its last
// error.
export async function withRetries<Result>(work: () => Promise<Result>, isWanted: () => boolean): Promise<Result> {
  for (let attempt = 0; ; ++attempt) {
    try {
      return await work();
    } catch (error) {
      if (!isTransient(error) || !isWanted()) throw error;
      await pause(backOff_ms(attempt));
      if (!isWanted()) throw error;
    }
  }
}

// Runs one operation at a time, and once more if it was requested meanwhile; begins them at least
// `period_ms` apart.
export class CoalescedTask {
  private isRunning = false;
  private isRequested = false;
  constructor(private readonly work: () => Promise<void>, private readonly period_ms = 0) {}

  request(): void {
    this.isRequested = true;
    if (!this.isRunning) void this.run();
  }

  private async run(): Promise<void> {
    this.isRunning = true;
    try {
      while (this.isRequested) {
        this.isRequested = false;
        const next_ms = performance.now() + this.period_ms;
        await this.work();
        const wait_ms = next_ms - performance.now();
        if (wait_ms > 0) await pause(wait_ms);
      }
    } finally {
      this.isRunning = false;
    }
  }
}

// Uses only the reply to the newest of successive requests.
export class LatestRequest {
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
