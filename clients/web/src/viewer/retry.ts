// What failed and may go well the next time is tried again, ever more patiently.
import { CallFailure } from "./link";
import { backOff_ms, resourceExhausted, unavailable } from "./messages";

// Other than a call: the server was busy, or the network away.
export class PassingFailure extends Error {}

export const isPassing = (error: unknown): boolean => error instanceof PassingFailure ||
  (error instanceof CallFailure && [unavailable, resourceExhausted].includes(error.error.code));

const pause = (ms: number): Promise<void> => new Promise((resolve) => setTimeout(resolve, ms));

// Until it goes well, fails for good or is not wanted any more; then with what it failed with.
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

// Does one thing at a time, and once more when it was asked for meanwhile.
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

// Of what is asked one after the other only the newest is heard.
export class Newest {
  private last = 0;
  private isOpen = false;

  // Says from then on whether it is still the newest.
  begin(): () => boolean {
    const own = ++this.last;
    this.isOpen = true;
    return () => own === this.last;
  }

  // Nothing is heard that was asked until now.
  drop(): void {
    ++this.last;
    this.isOpen = false;
  }

  // Something is asked that is not dropped.
  get isPending(): boolean { return this.isOpen; }
}
