// The messages between the page and its worker.
export type Json = Record<string, unknown>;

export type Method =
  | "WorldService/ListWorlds" | "WorldService/GetWorld" | "WorldService/ListObjects" | "WorldService/WatchWorld"
  | "RobotService/ListRobots" | "RobotService/GetRobotLinks" | "PerceptionService/ListScans"
  | "PerceptionService/ListSensors" | "PerceptionService/WatchFrames"
  | "RobotService/GetLinkPoses" | "QueryService/CheckCollisions" | "QueryService/CheckMotions" | "QueryService/GetDistances"
  | "QueryService/GetContacts" | "QueryService/CastRays" | "QueryService/SamplePoints";

// The error of a failed call.
export interface CallError {
  code: number;  // of gRPC
  name: string;  // "NOT_FOUND"
  message: string;
  reason: string;
  metadata?: Record<string, string>;  // of the reason
  fields: { field: string; description: string }[];
}

// `why`: the reason of the last failed attempt or lost connection; empty if unknown.
export type ConnectionState =
  | { is: "connecting"; why: string }
  | { is: "open" }
  | { is: "waiting"; why: string }   // to try again
  | { is: "refused"; why: string };  // for good

// The page gets a message of a paced call, and the next one when it asks for it: the newest by then.
export type ToWorker =
  | { what: "begin"; id: number; method: Method; request: Json; isPaced: boolean }
  | { what: "next"; id: number }
  | { what: "cancel"; id: number };

// `received_ms`: when the socket delivered the message, in the clock of `now_ms`.
export type FromWorker =
  | { what: "state"; state: ConnectionState }
  | { what: "message"; id: number; message: Json; received_ms: number }
  | { what: "end"; id: number; error?: CallError };

// Milliseconds since 1970, finer than Date.now(), and the same in the page and in its worker.
export const now_ms = (): number => performance.timeOrigin + performance.now();

export const unavailable = 14;
export const notFound = 5;
export const resourceExhausted = 8;
export const unimplemented = 12;  // by an older server

// The delay before the n-th attempt in a row, n from 0: short after a restart, never more than a
// few seconds.
export function backOff_ms(attempt: number): number {
  return Math.min(100 * 2 ** attempt, 3000);
}
