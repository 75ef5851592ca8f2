// Parses a query typed into the page into its call. Pure. The words are the command line's, with or
// without dashes; numbers are in metres and radians, separated by spaces or commas.
import type { Robot } from "../world/stream";
import type { Pose, ShapeOneOf } from "../world/types";
import type { Json, Method } from "./messages";
import { QueryError, Words, type QueryWorld } from "./query_words";
import { stateRow } from "./robot_state";

export { QueryError, type QueryWorld };

export type QueryKind = "distance" | "contacts" | "check" | "motion" | "ray" | "sample";

export interface Query {
  kind: QueryKind;
  method: Method;
  request: Json;  // without world and revision
  shape?: ShapeOneOf;       // the body of the query, at each of `at`
  object?: string;          // or an object of the world; without `at` where it stands
  robot?: RobotQuery;       // or a robot
  at: readonly Pose[];
  ray?: { from: number[]; direction: number[] };
  points: readonly number[][];  // of samples
}

// A robot in the states of `rows`, or without rows where it stands.
export interface RobotQuery { name: string; group: string; base?: Pose; rows: readonly number[][]; }

const methods: Record<QueryKind, Method> = {
  distance: "QueryService/GetDistances", contacts: "QueryService/GetContacts",
  check: "QueryService/CheckCollisions", motion: "QueryService/CheckMotions",
  ray: "QueryService/CastRays", sample: "QueryService/SamplePoints" };

const kindsText = "distance, contacts, check, motion, ray or sample";

const shapes: Record<string, { fields: readonly string[]; make: (n: number[]) => ShapeOneOf }> = {
  sphere: { fields: ["R"], make: ([r = 0]) => ({ sphere: { radius_m: r } }) },
  box: { fields: ["X", "Y", "Z"], make: ([x = 0, y = 0, z = 0]) => ({ box: { size_x_m: x, size_y_m: y, size_z_m: z } }) },
  cylinder: { fields: ["R", "L"], make: ([r = 0, l = 0]) => ({ cylinder: { radius_m: r, length_m: l } }) },
  cone: { fields: ["RB", "RT", "L"],
          make: ([b = 0, t = 0, l = 0]) => ({ cone: { radius_bottom_m: b, radius_top_m: t, length_m: l } }) },
  capsule: { fields: ["R", "L"], make: ([r = 0, l = 0]) => ({ capsule: { radius_m: r, length_m: l } }) },
};

export const grammar: readonly (readonly [form: string, meaning: string])[] = [
  ["distance BODY", "signed distance to the nearest object, the two points and the normal"],
  ["contacts BODY", "where it touches or penetrates"],
  ["check BODY", "free, or in collision and with what"],
  ["motion BODY, at or joints twice or more", "free all the way, or where it meets what"],
  ["ray from PLACE direction X Y Z", "what is hit first; or: to PLACE"],
  ["sample PLACE PLACE ...", "how far points are from everything, and which way that grows"],
  ["BODY", "SHAPE at PLACE · object NAME · robot NAME group NAME joints V V ... or STATE"],
  ["SHAPE", "sphere R · box X Y Z · cylinder R L · cone RB RT L · capsule R L"],
  ["PLACE", "X Y Z, of bodies also X Y Z QX QY QZ QW · NAME · NAME+DX,DY,DZ: an object's middle, moved"],
  ["at PLACE", "where a body is; an object or a robot is where it stands without; may be repeated"],
  ["max-results N · margin M · ignore NAME · unseen ignore|report|block · engine NAME ...",
   "options, in any order: those of cwm distance --help"],
];

export const examples: readonly string[] = [
  "distance sphere 0.05 at 0.5 0 1", "contacts box 0.1 0.1 0.2 at 0.5 0 1", "check object mug at 0.5 0.1 0.2",
  "distance box 0.1,0.2,0.06 at mug+0,0,0.2", "motion sphere 0.05 at 0 0 1 at mug+0,0,0.1",
  "check robot panda group panda_arm joints ready", "sample 0.5 0 1 mug+0,0,0.1", "ray from 0 0 1 direction 1 0 -0.3"];

// Words are typed by users: "constructor" must not match an inherited property.
function entry<Value>(record: Record<string, Value>, key: string): Value | undefined {
  return Object.hasOwn(record, key) ? record[key] : undefined;
}

interface Parts {
  shape?: ShapeOneOf;
  object?: string;
  robot?: string;
  group: string;
  joints: (number[] | string)[];  // numbers, or the name of a state
  at: Pose[];
  from?: number[];
  direction?: number[];
  to?: number[];
  points: number[][];
  robotOptions: Json;
  options: Json;
}

// A name of an enum in the API, as "ENGINE_FCL".
const enumReader = (field: string, prefix: string, choices: readonly string[]) =>
  (words: Words, options: Json, option: string): void => {
    options[field] = `${prefix}_${words.oneOf(option, choices).toUpperCase()}`;
  };

const numberReader = (field: string, letter: string) => (words: Words, options: Json, option: string): void => {
  [options[field]] = words.numbers(option, [letter]);
};

const append = (options: Json, field: string, value: unknown): void => {
  options[field] = [...(options[field] as unknown[] | undefined ?? []), value];
};

// "NAME" or "ROBOT:LINK".
function thing(text: string): Json {
  const [name = "", ...link] = text.split(":");
  return { name, link: link.join(":") };
}

type Reader = (words: Words, options: Json, option: string) => void;

const optionReaders: Record<string, Reader> = {
  "max-results": (words, options) => { options["max_results"] = words.count("max-results"); },
  "max-contacts": (words, options) => { options["max_contacts"] = words.count("max-contacts"); },
  "max-distance": numberReader("max_distance_m", "M"),
  margin: numberReader("margin_m", "M"),
  "margin-sigma": numberReader("margin_sigma", "K"),
  "support-tolerance": numberReader("support_tolerance_m", "M"),
  ignore: (words, options) => append(options, "ignore", words.name("ignore")),
  "ignore-pair": (words, options) =>
    append(options, "ignore_pairs", { a: thing(words.name("ignore-pair")), b: thing(words.name("ignore-pair")) }),
  unseen: enumReader("unseen", "UNSEEN_SPACE", ["ignore", "report", "block"]),
  engine: enumReader("engine", "ENGINE", ["auto", "exact", "fcl", "bullet"]),
  representation: enumReader("representation", "REPRESENTATION", ["hybrid", "shapes", "surfaces"]),
  "time-budget": (words, options) => { options["time_budget"] = `${words.numbers("time-budget", ["S"])[0]?.toFixed(9)}s`; },
};

const robotOptionReaders: Record<string, Reader> = {
  scope: enumReader("scope", "ROBOT_SCOPE", ["both", "world", "self"]),
  geometry: enumReader("robot_geometry", "ROBOT_GEOMETRY", ["exact", "spheres_as_given", "spheres_containing"]),
};

// Words of the command line that the page has no use for.
const elsewhere: Record<string, string> = {
  "at-revision": "the slider chooses the revision",
  "what-if": "only the command line can suppose changes",
  "exit-code": "it is for scripts, see the command line",
};

function readPart(words: Words, parts: Parts): void {
  const word = words.take() ?? "";
  const shape = entry(shapes, word);
  const option = entry(optionReaders, word);
  const robotOption = entry(robotOptionReaders, word);
  const away = entry(elsewhere, word);
  if (shape) {
    if (parts.shape) throw new QueryError(`${word}: only one shape at a time`);
    parts.shape = shape.make(words.numbers(word, shape.fields));
  } else if (option) option(words, parts.options, word);
  else if (robotOption) robotOption(words, parts.robotOptions, word);
  else if (away !== undefined) throw new QueryError(`${word}: ${away}`);
  else if (word === "object" || word === "robot") parts[word] = words.name(word);
  else if (word === "group") parts.group = words.name(word);
  else if (word === "joints") parts.joints.push(words.isNumber() ? words.row() : words.name(word));
  else if (word === "at" || word === "x-world-base") parts.at.push(words.pose(word));
  else if (word === "from" || word === "to") parts[word] = words.point(word);
  else if (word === "direction") parts.direction = words.numbers(word, ["X", "Y", "Z"]);
  else throw new QueryError(`"${word}" is no word of a question; press ? for all of them`);
}

// Whether a word begins an option rather than a place of a sample.
const isOption = (words: Words): boolean => !words.isQuoted && Object.hasOwn(optionReaders, words.next ?? "");

const base64 = (numbers: readonly number[]): string => {
  const bytes = new Uint8Array(new Float64Array(numbers).buffer);
  let text = "";
  for (const byte of bytes) text += String.fromCharCode(byte);
  return btoa(text);
};

const rows = (numbers: readonly number[]): Json => ({ scalar: "SCALAR_F64", data: base64(numbers) });

const poseRows = (all: readonly Pose[]): Json => rows(all.flatMap((at) => [at.tx_m, at.ty_m, at.tz_m, at.qx, at.qy, at.qz, at.qw]));

function rayQuery({ from, direction, to, options }: Parts): Query {
  if (!from) throw new QueryError("ray: from X Y Z is missing");
  if ((direction === undefined) === (to === undefined)) {
    throw new QueryError("ray: takes one of direction X Y Z and to X Y Z");
  }
  const along = direction ?? to?.map((value, i) => value - (from[i] ?? 0)) ?? [];
  if (Math.hypot(...along) === 0) throw new QueryError("ray: its direction must not be zero");
  return { kind: "ray", method: methods.ray, request: { rays: rows([...from, ...along]), options },
           ray: { from, direction: along }, at: [], points: [] };
}

function sampleQuery({ points, options }: Parts): Query {
  if (points.length === 0) throw new QueryError("sample: takes places, each X Y Z or NAME+DX,DY,DZ");
  return { kind: "sample", method: methods.sample, request: { points: rows(points.flat()), options }, at: [], points };
}

function robotQuery(kind: QueryKind, { robot: name = "", group, joints, at }: Parts, world: QueryWorld): RobotQuery {
  if (at.length > 1) throw new QueryError(`${kind}: at is the place of a robot's base, once; its states are joints`);
  const robot: Robot | undefined = world.robot(name);
  const all = joints.map((row) => (typeof row === "string" ? stateRow(robot, name, group, row) : row));
  const width = all[0]?.length ?? 0;
  const other = all.find((row) => row.length !== width);
  if (other) throw new QueryError(`joints: has ${other.length} numbers, must have ${width} as the first`);
  return { name, group, rows: all, ...(at[0] && { base: at[0] }) };
}

export const robotSubject = ({ name, group, base, rows: all }: RobotQuery): Json => ({
  robot: name, group, ...(base && { x_world_base: base }),
  ...(all.length > 0 && { rows: { ...rows(all.flat()), width: all[0]?.length ?? 0 } }) });

function bodyQuery(kind: QueryKind, parts: Parts, world: QueryWorld): Query {
  const { shape, object, robot, at, options, robotOptions } = parts;
  if ([shape, object, robot].filter((one) => one !== undefined).length !== 1) {
    throw new QueryError(`${kind}: takes one shape, object NAME or robot NAME`);
  }
  if (shape && at.length === 0) throw new QueryError(`${kind}: at X Y Z is missing, where the shape is`);
  if (robot === undefined && (parts.joints.length > 0 || parts.group !== "" || Object.keys(robotOptions).length > 0)) {
    throw new QueryError(`${kind}: robot NAME is missing, whose joints, group, scope or geometry these are`);
  }
  const query: Query = { kind, method: methods[kind], request: {}, at, points: [] };
  if (robot !== undefined) {
    query.robot = robotQuery(kind, parts, world);
    query.at = [];
    query.request = { subject: { robot: { ...robotSubject(query.robot), ...robotOptions } }, options };
  } else if (object !== undefined) {
    query.object = object;
    query.request = { subject: { object: { name: object, ...(at.length > 0 && { x_world_object: poseRows(at) }) } }, options };
  } else if (shape) {
    query.shape = shape;
    query.request = { subject: { shapes: { shapes: [shape], x_world_body: poseRows(at) } }, options };
  }
  if (kind !== "motion") return query;
  const count = query.robot ? query.robot.rows.length : at.length;
  if (count < 2) {
    throw new QueryError(`motion: leads through ${count === 1 ? "1 place" : "no places"}, must be at least 2: ` +
                         `${query.robot ? "joints" : "at"} twice or more`);
  }
  query.request["path_row_counts"] = [count];
  return query;
}

// Throws a QueryError.
export function parseQuery(text: string, world: QueryWorld): Query {
  const words = new Words(text, world);
  if (words.next === "cwm") words.take();  // copied from a shell
  const kind = words.take() ?? "";
  if (!Object.hasOwn(methods, kind)) throw new QueryError(`a question begins with ${kindsText}, not with "${kind}"`);
  const parts: Parts = { group: "", joints: [], at: [], points: [], robotOptions: {},
                         options: { result_form: "RESULT_FORM_ROWS", scalar: "SCALAR_F64" } };
  while (words.next !== undefined) {
    if (kind === "sample" && !isOption(words)) parts.points.push(words.point("sample"));
    else readPart(words, parts);
  }
  if (kind === "ray") return rayQuery(parts);
  return kind === "sample" ? sampleQuery(parts) : bodyQuery(kind as QueryKind, parts, world);
}
