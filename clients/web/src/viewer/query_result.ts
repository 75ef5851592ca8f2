// Converts the server's reply to rows of a table and to marks to draw. Pure.
import { fixed, mm } from "../page/quantity";
import { shortName, type Vector3 } from "../world/types";
import type { Query } from "./query";

// What a row says of the two bodies that meet: an object or a link of a robot. Without an object, a
// robot meets itself.
interface Meeting { object?: string; object_link?: string; body_link?: string; body_object?: string; }

export interface PairRow extends Meeting {
  distance_m: number;
  point_body?: Vector3;
  point_object?: Vector3;
  normal?: Vector3;
  object: string;
  object_part: number;
  trust: string;
  bound_m?: number;
}

export interface CollisionRow extends Meeting { verdict: string; trust: string; variable?: string; }

export interface MotionRow extends Meeting {
  verdict: string;
  segment?: number;  // the motion is free up to `lo` of this segment, and in contact at `hi`
  lo?: number;
  hi?: number;
  clearance_m?: number;
  trust: string;
  variable?: string;
}

export interface SampleRow {
  state: string;
  distance_m?: number;
  gradient?: Vector3;
  object?: string;
  object_link?: string;
  trust: string;
  bound_m?: number;
}

export interface RayRow {
  hit: boolean;
  distance_m?: number;
  point?: Vector3;
  normal?: Vector3;
  object?: string;
  object_link?: string;
  trust: string;
}

// The replies to all questions have one of these in `rows`.
export interface Reply { revision: string; rows: ({ answers: PairRow[] } | CollisionRow | MotionRow | RayRow | SampleRow)[]; }

// A line between two points in the world with a text beside it; a line of length 0 is a point.
export interface Mark { from: Vector3; to: Vector3; normal?: Vector3; text: string; touches: boolean; }

// A link that touches something; an empty `robot` is the one that was asked about, in its `row`: -1
// is the place where a motion stops.
export interface MarkedLink { robot: string; link: string; row: number; }

export interface QueryResult {
  title: string;
  verdict: "free" | "collision" | "neutral";
  columns: readonly string[];
  rows: string[][];
  marks: Mark[];      // the nearest or deepest first
  objects: string[];  // objects named in it
  touched: string[];  // objects in collision, where no marks tell it
  links: MarkedLink[];
  stop?: { segment: number; share: number };  // where a motion meets something
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
function named({ object, object_link, body_link }: Meeting): string {
  if (object) return object + (object_link ? `:${object_link}` : "");
  return body_link && object_link ? `itself (${body_link}, ${object_link})` : "itself";
}

// Each link once a row.
function linksOf(meetings: readonly { row: number; meeting: Meeting }[]): MarkedLink[] {
  const links = new Map<string, MarkedLink>();
  for (const { row, meeting: { object = "", object_link, body_link } } of meetings) {
    if (body_link) links.set(`${row}::${body_link}`, { robot: "", link: body_link, row });
    if (object_link) links.set(`${row}:${object}:${object_link}`, { robot: object, link: object_link, row });
  }
  return [...links.values()];
}

const objectsOf = (meetings: readonly Meeting[]): string[] => [...new Set(meetings.flatMap(({ object }) => (object ? [object] : [])))];

// "out of limits" for "VERDICT_OUT_OF_LIMITS", with the variable if it is named.
const verdictText = ({ verdict, variable }: { verdict: string; variable?: string }, type: string): string =>
  shortName(verdict, type).replaceAll("_", " ") + (variable ? `: ${variable}` : "");

const capital = (text: string): string => text.slice(0, 1).toUpperCase() + text.slice(1);

// The table with a first column of row numbers, if there are several rows.
function numbered(columns: readonly string[], perRow: readonly (readonly string[][])[]): Pick<QueryResult, "columns" | "rows"> {
  if (perRow.length <= 1) return { columns, rows: perRow.flat() };
  return { columns: ["row", ...columns], rows: perRow.flatMap((lines, i) => lines.map((line) => [String(i), ...line])) };
}

function pairsResult(kind: "distance" | "contacts", perRow: readonly (readonly PairRow[])[]): QueryResult {
  const pairs = perRow.flat().sort((a, b) => Number(a.distance_m) - Number(b.distance_m));
  const deepest = Math.min(...pairs.map((row) => Number(row.distance_m)));
  const none = kind === "contacts" ? "No contact" : "Nothing within reach";
  const touching = kind === "contacts" ? pairs.length > 0 : deepest < 0;
  const title = pairs.length === 0 ? none
    : kind === "contacts" ? `${pairs.length} contact${pairs.length === 1 ? "" : "s"}, deepest ${length(Math.max(-deepest, 0))}`
    : deepest < 0 ? `In contact, ${length(-deepest)} deep` : `${length(deepest)} away`;
  return {
    title, verdict: touching ? "collision" : "free",
    ...numbered(["object", "distance", "on the object, m", "normal", "trust"], perRow.map((answers) => answers.map((row) => [
      named(row), length(row.distance_m), triple(row.point_object, 4), triple(row.normal, 3), accuracyOf(row)]))),
    marks: pairs.flatMap((row) => (row.point_body && row.point_object ? [{
      from: row.point_body, to: row.point_object, text: length(row.distance_m), touches: row.distance_m < 0,
      ...(row.normal && { normal: row.normal }) }] : [])),
    objects: objectsOf(pairs), touched: [],
    links: linksOf(perRow.flatMap((answers, row) =>
      answers.filter(({ distance_m }) => distance_m < 0).map((meeting) => ({ row, meeting })))),
  };
}

function collisionResult(rows: readonly CollisionRow[]): QueryResult {
  const collisions = rows.filter(({ verdict }) => verdict === "VERDICT_COLLISION");
  const worst = collisions[0] ?? rows.find(({ verdict }) => verdict !== "VERDICT_FREE") ?? rows[0];
  const title = collisions[0] ? `In collision with ${named(collisions[0])}` : capital(verdictText(worst ?? { verdict: "" }, "VERDICT"));
  return {
    title, verdict: worst?.verdict === "VERDICT_FREE" ? "free" : collisions[0] ? "collision" : "neutral",
    ...numbered(["verdict", "object", "trust"], rows.map((row) => [[
      verdictText(row, "VERDICT"), row.verdict === "VERDICT_COLLISION" ? named(row) : "", accuracyOf(row)]])),
    marks: [], objects: objectsOf(rows), touched: objectsOf(collisions.filter(({ object_link }) => !object_link)),
    links: linksOf(rows.flatMap((meeting, row) => (meeting.verdict === "VERDICT_COLLISION" ? [{ row, meeting }] : []))),
  };
}

function motionTitle(row: MotionRow): string {
  const { verdict, segment = 0, hi = 0, clearance_m } = row;
  if (verdict === "MOTION_VERDICT_FREE") return `Free all the way${clearance_m === undefined ? "" : `, keeps ${length(clearance_m)}`}`;
  if (verdict !== "MOTION_VERDICT_CONTACT") return capital(verdictText(row, "MOTION_VERDICT"));
  return `Meets ${named(row)} at ${fixed(100 * hi, 1)} % of segment ${segment}`;
}

function motionResult(rows: readonly MotionRow[]): QueryResult {
  const contacts = rows.filter(({ verdict }) => verdict === "MOTION_VERDICT_CONTACT");
  const worst = contacts[0] ?? rows.find(({ verdict }) => verdict !== "MOTION_VERDICT_FREE") ?? rows[0];
  return {
    title: worst ? motionTitle(worst) : "Not computed",
    verdict: worst?.verdict === "MOTION_VERDICT_FREE" ? "free" : contacts[0] ? "collision" : "neutral",
    ...numbered(["verdict", "object", "segment", "free to", "met at", "clearance", "trust"], rows.map((row) => [[
      verdictText(row, "MOTION_VERDICT"), row.verdict === "MOTION_VERDICT_CONTACT" ? named(row) : "", String(row.segment ?? ""),
      row.lo === undefined ? "" : fixed(row.lo, 4), row.hi === undefined ? "" : fixed(row.hi, 4),
      row.clearance_m === undefined ? "" : length(row.clearance_m), accuracyOf(row)]])),
    marks: [], objects: objectsOf(rows), touched: objectsOf(contacts.filter(({ object_link }) => !object_link)),
    links: linksOf(contacts.map((meeting) => ({ row: -1, meeting }))),
    ...(contacts[0] && { stop: { segment: contacts[0].segment ?? 0, share: contacts[0].hi ?? 0 } }),
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
    objects: objectsOf(rows), touched: [], links: [],
  };
}

const vectorOf = ([x = 0, y = 0, z = 0]: readonly number[]): Vector3 => ({ x, y, z });

// A line leads from the point to the surface that is nearest by its gradient.
function sampleMark(point: Vector3, { distance_m, gradient }: SampleRow): Mark | undefined {
  if (distance_m === undefined) return undefined;
  const g = gradient ?? { x: 0, y: 0, z: 0 };
  const to = { x: point.x - distance_m * g.x, y: point.y - distance_m * g.y, z: point.z - distance_m * g.z };
  return { from: point, to, text: length(distance_m), touches: distance_m < 0 };
}

function sampleResult(rows: readonly SampleRow[], points: Query["points"]): QueryResult {
  const near = rows.map((row, i) => ({ row, mark: sampleMark(vectorOf(points[i] ?? []), row) }))
    .filter(({ mark }) => mark).sort((a, b) => Number(a.row.distance_m) - Number(b.row.distance_m));
  const [first] = near;
  const distance_m = first?.row.distance_m ?? 0;
  return {
    title: !first ? "Nothing within reach" : distance_m < 0 ? `Inside ${named(first.row)}, ${length(-distance_m)} deep`
      : `${length(distance_m)} away from ${named(first.row)}`,
    verdict: !first ? "free" : distance_m < 0 ? "collision" : "free",
    ...numbered(["object", "distance", "grows along", "where", "trust"], rows.map((row) => [[
      row.object ? named(row) : "none", row.distance_m === undefined ? "" : length(row.distance_m), triple(row.gradient, 3),
      verdictText({ verdict: row.state }, "SAMPLE_STATE"), accuracyOf(row)]])),
    marks: near.map(({ mark }) => mark as Mark), objects: objectsOf(rows), touched: [], links: [],
  };
}

export function parseResult(query: Query, reply: Reply): QueryResult {
  if (query.kind === "ray" && query.ray) return rayResult(reply.rows as RayRow[], query.ray);
  if (query.kind === "check") return collisionResult(reply.rows as CollisionRow[]);
  if (query.kind === "motion") return motionResult(reply.rows as MotionRow[]);
  if (query.kind === "sample") return sampleResult(reply.rows as SampleRow[], query.points);
  const perRow = (reply.rows as { answers: PairRow[] }[]).map(({ answers }) => answers);
  return pairsResult(query.kind === "contacts" ? "contacts" : "distance", perRow);
}
