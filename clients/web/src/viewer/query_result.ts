// Converts the server's reply to rows of a table and to marks to draw. Pure.
import { fixed, mm } from "../page/quantity";
import { shortName, type Vector3 } from "../world/types";
import type { Query } from "./query";

export interface PairRow {
  distance_m: number;
  point_body?: Vector3;
  point_object?: Vector3;
  normal?: Vector3;
  object: string;
  object_part: number;
  object_link?: string;
  body_link?: string;
  trust: string;
  bound_m?: number;
}

export interface CollisionRow { verdict: string; object?: string; object_link?: string; body_link?: string; trust: string; }

export interface RayRow {
  hit: boolean;
  distance_m?: number;
  point?: Vector3;
  normal?: Vector3;
  object?: string;
  object_link?: string;
  trust: string;
}

// The replies to all four questions have one of these in `rows`.
export interface Reply { revision: string; rows: ({ answers: PairRow[] } | CollisionRow | RayRow)[]; }

// A line between two points in the world with a text beside it; a line of length 0 is a point.
export interface Mark { from: Vector3; to: Vector3; normal?: Vector3; text: string; touches: boolean; }

export interface QueryResult {
  title: string;
  verdict: "free" | "collision" | "neutral";
  columns: readonly string[];
  rows: string[][];
  marks: Mark[];
  objects: string[];  // objects named in it
}

// JSON writes numbers that are not finite as strings.
const length = (m: number): string => (Number.isFinite(Number(m)) ? `${mm(Number(m), 2)} mm` : String(m));

const triple = (v: Vector3 | undefined, decimals: number): string =>
  (v ? [v.x, v.y, v.z].map((value) => fixed(value, decimals)).join("  ") : "");

const accuracyOf = (row: { trust: string; bound_m?: number }): string => {
  const word = shortName(row.trust, "TRUST").replace("_", " ");
  return row.bound_m ? `${word}, ± ${mm(row.bound_m, 3)} mm` : word;
};

// A robot may collide with itself; then its two links are named.
function named({ object, object_link, body_link }: { object?: string; object_link?: string; body_link?: string }): string {
  if (object) return object + (object_link ? `:${object_link}` : "");
  return body_link && object_link ? `itself (${body_link}, ${object_link})` : "itself";
}

function pairsResult(kind: "distance" | "contacts", pairs: readonly PairRow[]): QueryResult {
  const deepest = Math.min(...pairs.map((row) => Number(row.distance_m)));
  const none = kind === "contacts" ? "No contact" : "Nothing within reach";
  const touching = kind === "contacts" ? pairs.length > 0 : deepest < 0;
  const title = pairs.length === 0 ? none
    : kind === "contacts" ? `${pairs.length} contact${pairs.length === 1 ? "" : "s"}, deepest ${length(Math.max(-deepest, 0))}`
    : deepest < 0 ? `In contact, ${length(-deepest)} deep` : `${length(deepest)} away`;
  return {
    title, verdict: touching ? "collision" : "free",
    columns: ["object", "distance", "on the object, m", "normal", "trust"],
    rows: pairs.map((row) => [
      named(row), length(row.distance_m), triple(row.point_object, 4), triple(row.normal, 3), accuracyOf(row)]),
    marks: pairs.flatMap((row) => (row.point_body && row.point_object ? [{
      from: row.point_body, to: row.point_object, text: length(row.distance_m), touches: row.distance_m < 0,
      ...(row.normal && { normal: row.normal }) }] : [])),
    objects: [...new Set(pairs.map(({ object }) => object))],
  };
}

function collisionResult(rows: readonly CollisionRow[]): QueryResult {
  const worst = rows.find(({ verdict }) => verdict === "VERDICT_COLLISION") ?? rows[0];
  const word = shortName(worst?.verdict ?? "", "VERDICT").replaceAll("_", " ");
  const title = worst?.verdict === "VERDICT_COLLISION" ? `In collision with ${named(worst)}` : word[0]?.toUpperCase() + word.slice(1);
  return {
    title, verdict: word === "free" ? "free" : word === "collision" ? "collision" : "neutral",
    columns: ["verdict", "object", "trust"],
    rows: rows.map((row) => [shortName(row.verdict, "VERDICT").replaceAll("_", " "),
                             row.verdict === "VERDICT_COLLISION" ? named(row) : "", accuracyOf(row)]),
    marks: [], objects: rows.flatMap(({ object }) => (object ? [object] : [])),
  };
}

// The drawn length of a ray that hits nothing.
const missLength_m = 5;

function rayResult(rows: readonly RayRow[], { from: start, direction }: NonNullable<Query["ray"]>): QueryResult {
  const norm = Math.hypot(...direction);
  const at = (i: number): number => start[i] ?? 0;
  const reach = (i: number): number => at(i) + (missLength_m * (direction[i] ?? 0)) / norm;
  const from = { x: at(0), y: at(1), z: at(2) };
  const hit = rows.find((row) => row.hit);
  return {
    title: hit ? `Hits ${named(hit)} after ${length(hit.distance_m ?? 0)}` : "Hits nothing", verdict: "neutral",
    columns: ["object", "distance", "point, m", "normal", "trust"],
    rows: rows.map((row) => (row.hit
      ? [named(row), length(row.distance_m ?? 0), triple(row.point, 4), triple(row.normal, 3), accuracyOf(row)]
      : ["none", "", "", "", accuracyOf(row)])),
    marks: rows.map((row) => ({
      from, to: row.point ?? { x: reach(0), y: reach(1), z: reach(2) }, text: row.hit ? length(row.distance_m ?? 0) : "",
      touches: row.hit, ...(row.normal && { normal: row.normal }) })),
    objects: rows.flatMap(({ object }) => (object ? [object] : [])),
  };
}

export function parseResult(query: Query, reply: Reply): QueryResult {
  if (query.kind === "ray" && query.ray) return rayResult(reply.rows as RayRow[], query.ray);
  if (query.kind === "check") return collisionResult(reply.rows as CollisionRow[]);
  const pairs = (reply.rows as { answers: PairRow[] }[]).flatMap(({ answers }) => answers);
  return pairsResult(query.kind === "contacts" ? "contacts" : "distance", pairs);
}
