// Draws a result: the body of the query, lines between nearest points, contacts with their
// normals.
import { Matrix4, Vector3 } from "three";
import type { Vector3 as ApiVector3 } from "../../world/types";
import { matrixOf } from "../../scene/pose";
import type { QueryResult } from "../query_result";
import type { Query } from "../query";
import type { Label } from "./labels";
import { arrowSegments, type Segment } from "./lines";
import { shapeParts } from "./parts";
import type { DrawnObject } from "./world_view";

const freeColor = "#1f8fff";
const touchColor = "#e5383b";

export interface ResultPicture { body: DrawnObject | undefined; segments: Segment[]; labels: Label[]; }

export const bodyName = "\u0000question";  // no object can have this name

const vector = ({ x, y, z }: ApiVector3): Vector3 => new Vector3(x, y, z);

// Three short strokes: a point, seen from anywhere.
function crossSegments(at: Vector3, size_m: number, color: string): Segment[] {
  return [0, 1, 2].map((axis) => {
    const arm = new Vector3().setComponent(axis, size_m);
    return { from: at.clone().sub(arm), to: at.clone().add(arm), color };
  });
}

export function bodyOf({ subject }: Query, verdict: QueryResult["verdict"] | "asked"): DrawnObject | undefined {
  if (!subject) return undefined;
  const color = verdict === "collision" ? touchColor : freeColor;
  const X: Matrix4 = matrixOf(subject.at);
  return {
    name: bodyName, color, shape: JSON.stringify(subject.shape), frames: [X],
    parts: shapeParts({ ...subject.shape, role: "", coefficients: [] }, "shapes", "ghost").map((part) => ({ frame: 0, part })) };
}

// `scale_m`, the length of strokes, is about a twentieth of the picture's extent.
export function resultPicture(query: Query, result: QueryResult, scale_m: number): ResultPicture {
  const segments: Segment[] = [];
  const labels: Label[] = [];
  for (const { from, to, normal, text, touches } of result.marks) {
    const color = touches && query.kind !== "ray" ? touchColor : freeColor;
    const [a, b] = [vector(from), vector(to)];
    segments.push({ from: a, to: b, color }, ...crossSegments(b, 0.12 * scale_m, color));
    if (query.kind !== "ray") segments.push(...crossSegments(a, 0.12 * scale_m, color));
    if (normal) segments.push(...arrowSegments(b, vector(normal), scale_m, "#f59f00"));
    if (text !== "") labels.push({ text, at: a.add(b).multiplyScalar(0.5), kind: "mark" });
  }
  return { body: bodyOf(query, result.verdict), segments, labels };
}
