// Converts messages of cwm.v1 between bytes and protobuf JSON; used only by the worker.
import { create, fromBinary, fromJson, toBinary, toJson, type DescMessage, type JsonValue } from "@bufbuild/protobuf";
import { BadRequestSchema, ErrorInfoSchema, StatusSchema } from "../../generated/cwm/v1/error_details_pb";
import { PerceptionService, WatchFramesResponseSchema } from "../../generated/cwm/v1/perception_pb";
import { QueryService } from "../../generated/cwm/v1/query_pb";
import { RobotService } from "../../generated/cwm/v1/robot_pb";
import { ViewerRequestSchema, ViewerResponseSchema, type ViewerCallEnd, type ViewerResponse }
  from "../../generated/cwm/v1/viewer_pb";
import { WorldService } from "../../generated/cwm/v1/world_pb";
import type { CallError, Json, Method } from "./messages";

const services = [WorldService, RobotService, PerceptionService, QueryService];

interface Shape { input: DescMessage; output: DescMessage; }

function shapeOf(method: Method): Shape {
  for (const service of services) {
    for (const one of service.methods) {
      if (`${service.name}/${one.name}` === method) return one;
    }
  }
  throw new Error(`method: ${method} is none of the server's`);
}

export function beginBytes(call_id: number, method: Method, request: Json): Uint8Array<ArrayBuffer> {
  const { input } = shapeOf(method);
  const bytes = toBinary(input, fromJson(input, request as JsonValue));
  return toBinary(ViewerRequestSchema, create(ViewerRequestSchema, {
    callId: BigInt(call_id), what: { case: "begin", value: { method: `cwm.v1.${method}`, request: bytes } } }));
}

export function cancelBytes(call_id: number): Uint8Array<ArrayBuffer> {
  return toBinary(ViewerRequestSchema, create(ViewerRequestSchema, {
    callId: BigInt(call_id), what: { case: "cancel", value: true } }));
}

export const responseOf = (bytes: Uint8Array): ViewerResponse => fromBinary(ViewerResponseSchema, bytes);

// Field names as in the .proto, and every field that is not a message or optional there.
const jsonOptions = { useProtoFieldName: true, alwaysEmitImplicit: true };

// A message for the page, and the buffers that go with it.
export interface DecodedMessage { message: Json; buffers: ArrayBuffer[]; }

export function messageOf(method: Method, bytes: Uint8Array): DecodedMessage {
  if (method === "PerceptionService/WatchFrames") return pointsOf(bytes);
  const { output } = shapeOf(method);
  return { message: toJson(output, fromBinary(output, bytes), jsonOptions) as Json, buffers: [] };
}

// Points stay bytes, in the buffer that came from the socket: as text they would be read twice.
function pointsOf(bytes: Uint8Array): DecodedMessage {
  const decoded = fromBinary(WatchFramesResponseSchema, bytes);
  const { points, classes } = decoded;
  decoded.points = decoded.classes = new Uint8Array();
  const buffers = new Set([points.buffer, classes.buffer] as ArrayBuffer[]);
  return { message: { ...(toJson(WatchFramesResponseSchema, decoded, jsonOptions) as Json), points, classes },
           buffers: [...buffers].filter(({ byteLength }) => byteLength > 0) };
}

const codeNames = [
  "OK", "CANCELLED", "UNKNOWN", "INVALID_ARGUMENT", "DEADLINE_EXCEEDED", "NOT_FOUND", "ALREADY_EXISTS",
  "PERMISSION_DENIED", "RESOURCE_EXHAUSTED", "FAILED_PRECONDITION", "ABORTED", "OUT_OF_RANGE", "UNIMPLEMENTED",
  "INTERNAL", "UNAVAILABLE", "DATA_LOSS", "UNAUTHENTICATED"];

export function errorOf(end: ViewerCallEnd): CallError {
  const error: CallError = {
    code: end.code, name: codeNames[end.code] ?? String(end.code), message: end.message, reason: "", fields: [] };
  if (end.details.length === 0) return error;
  for (const { typeUrl, value } of fromBinary(StatusSchema, end.details).details) {
    if (typeUrl.endsWith("/google.rpc.ErrorInfo")) {
      const { reason, metadata } = fromBinary(ErrorInfoSchema, value);
      Object.assign(error, { reason, metadata });
    }
    if (typeUrl.endsWith("/google.rpc.BadRequest")) {
      error.fields = fromBinary(BadRequestSchema, value).fieldViolations
        .map(({ field, description }) => ({ field, description }));
    }
  }
  return error;
}
