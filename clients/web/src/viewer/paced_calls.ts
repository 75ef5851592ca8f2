// Calls whose reader asks for every message, so that none queues up in a busy page: while the reader
// is busy, the newest message waits and takes the place of the one before. Pure.
interface PacedCall<Message> { isAwaited: boolean; waiting: Message | undefined; }

export class PacedCalls<Message> {
  private readonly calls = new Map<number, PacedCall<Message>>();

  begin(id: number): void { this.calls.set(id, { isAwaited: true, waiting: undefined }); }

  end(id: number): void { this.calls.delete(id); }

  // Returns the message if the reader awaits it or the call is not paced, and keeps it otherwise.
  offer(id: number, message: Message): Message | undefined {
    const call = this.calls.get(id);
    if (!call) return message;
    if (!call.isAwaited) {
      call.waiting = message;
      return undefined;
    }
    call.isAwaited = false;
    return message;
  }

  // Called when the reader has used a message: returns the newest one since, or awaits it.
  next(id: number): Message | undefined {
    const call = this.calls.get(id);
    if (!call) return undefined;
    const { waiting } = call;
    call.waiting = undefined;
    call.isAwaited = waiting === undefined;
    return waiting;
  }
}
