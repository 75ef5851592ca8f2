// Unary calls of the server over gRPC's protocol, for changes that follow each other faster than a
// command can be started. cited: "gRPC over HTTP2", github.com/grpc/grpc/blob/master/doc/PROTOCOL-HTTP2.md.
import { connect as connectHttp2, type ClientHttp2Session } from "node:http2";
import { connect as connectSocket } from "node:net";
import { create, toBinary, type MessageInitShape } from "@bufbuild/protobuf";
import { ApplyChangesRequestSchema } from "../../../clients/web/generated/cwm/v1/world_pb";

const prefixBytes = 5;  // not compressed, and the length

export class GrpcCaller {
  private readonly session: ClientHttp2Session;

  constructor(socketPath: string) {
    this.session = connectHttp2("http://localhost", { createConnection: () => connectSocket(socketPath) });
  }

  // Throws with the server's message if it refuses the changes.
  applyChanges(request: MessageInitShape<typeof ApplyChangesRequestSchema>): Promise<void> {
    return this.call("cwm.v1.WorldService/ApplyChanges", toBinary(ApplyChangesRequestSchema, create(ApplyChangesRequestSchema, request)));
  }

  close(): void { this.session.close(); }

  private call(method: string, body: Uint8Array): Promise<void> {
    const framed = new Uint8Array(prefixBytes + body.length);
    new DataView(framed.buffer).setUint32(1, body.length);
    framed.set(body, prefixBytes);
    return new Promise((resolve, reject) => {
      const stream = this.session.request({
        ":method": "POST", ":path": `/${method}`, "content-type": "application/grpc+proto", te: "trailers" });
      const note = (headers: Record<string, unknown>): void => {
        if (headers["grpc-status"] === undefined) return;
        if (headers["grpc-status"] === "0") resolve();
        else reject(new Error(`${method}: ${decodeURIComponent(String(headers["grpc-message"]))}`));
      };
      stream.on("response", note);
      stream.on("trailers", note);
      stream.on("error", reject);
      stream.on("close", () => reject(new Error(`${method}: ended without a status`)));
      stream.resume();
      stream.end(framed);
    });
  }
}
