// The page's end of the worker: unary calls and streams.
import type { CallError, FromWorker, Json, ConnectionState, Method, ToWorker } from "./messages";

export class CallFailure extends Error {
  constructor(readonly error: CallError) { super(error.message); }
}

export interface StreamReader<Message> {
  message: (message: Message, received_ms: number) => void;  // by now_ms()
  end: (error: CallError | undefined) => void;
}

export interface PacedStream { next: () => void; cancel: () => void; }

export class RpcClient {
  private readonly worker: Worker;
  private readonly readers = new Map<number, StreamReader<Json>>();
  private lastId = 0;
  onState: (state: ConnectionState) => void = () => {};

  constructor(script: string) {
    this.worker = new Worker(script, { type: "module" });
    this.worker.onmessage = (event: MessageEvent<FromWorker>) => {
      const said = event.data;
      if (said.what === "state") this.onState(said.state);
      else if (said.what === "message") this.readers.get(said.id)?.message(said.message, said.received_ms);
      else this.end(said.id, said.error);
    };
  }

  // Returns a function that ends the stream; afterwards the reader is not called.
  stream<Message>(method: Method, request: Json, reader: StreamReader<Message>): () => void {
    return this.begin(method, request, reader, false).cancel;
  }

  // A stream that sends a message only after `next` was called for the one before.
  pacedStream<Message>(method: Method, request: Json, reader: StreamReader<Message>): PacedStream {
    return this.begin(method, request, reader, true);
  }

  // The reply of a unary call; throws a CallFailure.
  call<Message>(method: Method, request: Json): Promise<Message> {
    return new Promise((resolve, reject) => {
      let result: Message | undefined;
      this.stream<Message>(method, request, {
        message: (message) => { result = message; },
        end: (error) => {
          if (error) reject(new CallFailure(error));
          else if (result !== undefined) resolve(result);
        },
      });
    });
  }

  private begin<Message>(method: Method, request: Json, reader: StreamReader<Message>, isPaced: boolean): PacedStream {
    const id = ++this.lastId;
    this.readers.set(id, reader as unknown as StreamReader<Json>);
    this.post({ what: "begin", id, method, request, isPaced });
    return {
      next: () => { if (this.readers.has(id)) this.post({ what: "next", id }); },
      cancel: () => { if (this.readers.delete(id)) this.post({ what: "cancel", id }); } };
  }

  private post(message: ToWorker): void { this.worker.postMessage(message); }

  private end(id: number, error: CallError | undefined): void {
    const reader = this.readers.get(id);
    this.readers.delete(id);
    reader?.end(error);
  }
}
