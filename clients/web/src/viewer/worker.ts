// The connection, on a thread of its own: bytes of the socket, messages of the page.
import { beginBytes, cancelBytes, errorOf, messageOf, responseOf } from "./codec";
import { backOff_ms, now_ms, unavailable, type CallError, type FromWorker, type Json, type ConnectionState, type Method, type ToWorker }
  from "./messages";
import { fetchConnectionError } from "./connection_error";
import { HeartbeatMonitor } from "./heartbeat";
import { PacedCalls } from "./paced_calls";

// The type libraries for workers and for documents exclude each other; only this function is
// needed.
declare function postMessage(message: FromWorker, transfer?: ArrayBuffer[]): void;

// chosen: a socket that does not open within this time will not open at all.
const patience_ms = 5000;

// The period of checks for a silent connection.
const listen_ms = 1000;

interface Received { bytes: Uint8Array; received_ms: number; }

const openCalls = new Map<number, Method>();
const pacedCalls = new PacedCalls<Received>();
let socket: WebSocket | undefined;
let attempt = 0;
let why = "";  // the reason of the last failure
const heartbeat = new HeartbeatMonitor();

const tell = (state: ConnectionState): void => postMessage({ what: "state", state });

function end(id: number, error?: CallError): void {
  if (!openCalls.delete(id)) return;
  pacedCalls.end(id);
  postMessage(error ? { what: "end", id, error } : { what: "end", id });
}

const gone = (message: string): CallError =>
  ({ code: unavailable, name: "UNAVAILABLE", message, reason: "", fields: [] });

function receive(bytes: Uint8Array): void {
  heartbeat.received(Date.now());
  const { callId, what } = responseOf(bytes);
  const id = Number(callId);
  if (!openCalls.has(id)) return;  // the call was cancelled
  guarded(id, () => {
    if (what.case === "message") deliver(id, pacedCalls.offer(id, { bytes: what.value, received_ms: now_ms() }));
    else if (what.case === "end") end(id, what.value.code === 0 ? undefined : errorOf(what.value));
  });
}

function deliver(id: number, received: Received | undefined): void {
  const method = openCalls.get(id);
  if (!received || method === undefined) return;
  const { message, buffers } = messageOf(method, received.bytes);
  postMessage({ what: "message", id, message, received_ms: received.received_ms }, buffers);
}

// A lost message loses the call; a watch begins anew.
function guarded(id: number, work: () => void): void {
  try {
    work();
  } catch (error) {
    socket?.send(cancelBytes(id));
    end(id, gone(`a message of the server cannot be read: ${String(error)}`));
  }
}

// The page gets the reason before it learns that its calls are over.
function over(state: ConnectionState, message: string): void {
  socket = undefined;
  tell(state);
  for (const id of [...openCalls.keys()]) end(id, gone(message));
}

// Reconnects afterwards.
function lost(from: WebSocket, reason: string, wait_ms = backOff_ms(attempt++)): void {
  if (socket !== from) return;
  why = reason;
  over({ is: "waiting", why }, "the connection to the server was lost");
  setTimeout(open, wait_ms);
}

// Does not wait for the close event, which a dead network never delivers.
function drop(silent: WebSocket): void {
  silent.onmessage = silent.onclose = null;
  silent.close();
  lost(silent, "the server was silent");
}

// Handles a socket that never opened.
async function failed(to: WebSocket): Promise<void> {
  const error = await fetchConnectionError(patience_ms);
  if (socket !== to) return;
  if (!error.isFinal) return lost(to, error.why, Math.max(error.wait_ms, backOff_ms(attempt++)));
  over({ is: "refused", why: error.why }, error.why);
}

function open(): void {
  tell({ is: "connecting", why });
  const scheme = self.location.protocol === "https:" ? "wss" : "ws";
  const opening = new WebSocket(`${scheme}://${self.location.host}/socket`);
  socket = opening;
  opening.binaryType = "arraybuffer";
  let isOpened = false;
  const overdue = setTimeout(() => opening.close(), patience_ms);
  opening.onopen = () => {
    clearTimeout(overdue);
    isOpened = true;
    attempt = 0;
    why = "";
    heartbeat.opened(Date.now());
    tell({ is: "open" });
  };
  opening.onmessage = (event) => receive(new Uint8Array(event.data as ArrayBuffer));
  opening.onclose = (event) => {
    clearTimeout(overdue);
    if (isOpened) lost(opening, event.reason);
    else void failed(opening);
  };
}

function listen(): void {
  if (socket?.readyState === WebSocket.OPEN && openCalls.size > 0 && heartbeat.isTimedOut(Date.now())) drop(socket);
}

// An invalid request, such as a number that does not fit its field, is not sent.
function begin(id: number, method: Method, request: Json, on: WebSocket): void {
  try {
    on.send(beginBytes(id, method, request));
  } catch (error) {
    end(id, { code: 3, name: "INVALID_ARGUMENT", message: String(error), reason: "", fields: [] });
  }
}

self.onmessage = (event: MessageEvent<ToWorker>) => {
  const message = event.data;
  if (message.what === "cancel") {
    pacedCalls.end(message.id);
    if (openCalls.delete(message.id)) socket?.send(cancelBytes(message.id));
    return;
  }
  if (message.what === "next") {
    guarded(message.id, () => deliver(message.id, pacedCalls.next(message.id)));
    return;
  }
  if (openCalls.size === 0) heartbeat.received(Date.now());  // nothing was expected until now
  openCalls.set(message.id, message.method);
  if (message.isPaced) pacedCalls.begin(message.id);
  if (socket?.readyState !== WebSocket.OPEN) {
    end(message.id, gone("there is no connection to the server"));
    return;
  }
  begin(message.id, message.method, message.request, socket);
};

open();
setInterval(listen, listen_ms);
