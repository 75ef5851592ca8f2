// Parses a query typed into the page into its call. Pure. The words are the command line's, with or
// without dashes; numbers are in metres, separated by spaces or commas.
import type { Pose, ShapeOneOf } from "../world/types";
import type { Json, Method } from "./messages";

export type QueryKind = "distance" | "contacts" | "check" | "ray";

export interface Query {
  kind: QueryKind;
  method: Method;
  request: Json;  // without world and revision
  subject?: { shape: ShapeOneOf; at: Pose };  // the body of the query, to be drawn
  object?: string;
  ray?: { from: number[]; direction: number[] };
}

// The message is a sentence about the error in the text.
export class QueryError extends Error {}

const methods: Record<QueryKind, Method> = {
  distance: "QueryService/GetDistances", contacts: "QueryService/GetContacts",
  check: "QueryService/CheckCollisions", ray: "QueryService/CastRays" };

const shapes: Record<string, { fields: readonly string[]; make: (n: number[]) => ShapeOneOf }> = {
  sphere: { fields: ["R"], make: ([r = 0]) => ({ sphere: { radius_m: r } }) },
  box: { fields: ["X", "Y", "Z"], make: ([x = 0, y = 0, z = 0]) => ({ box: { size_x_m: x, size_y_m: y, size_z_m: z } }) },
  cylinder: { fields: ["R", "L"], make: ([r = 0, l = 0]) => ({ cylinder: { radius_m: r, length_m: l } }) },
  cone: { fields: ["RB", "RT", "L"],
          make: ([b = 0, t = 0, l = 0]) => ({ cone: { radius_bottom_m: b, radius_top_m: t, length_m: l } }) },
  capsule: { fields: ["R", "L"], make: ([r = 0, l = 0]) => ({ capsule: { radius_m: r, length_m: l } }) },
};

export const grammar: readonly (readonly [form: string, meaning: string])[] = [
  ["distance SHAPE at X Y Z", "signed distance to the nearest object, the two points and the normal"],
  ["contacts SHAPE at X Y Z", "where it touches or penetrates"],
  ["check SHAPE at X Y Z", "free, or in collision and with what"],
  ["ray from X Y Z direction X Y Z", "what is hit first; or: to X Y Z"],
  ["SHAPE", "sphere R · box X Y Z · cylinder R L · cone RB RT L · capsule R L · object NAME · robot NAME"],
  ["at X Y Z [QX QY QZ QW]", "where it is; an object or a robot stands where it is without"],
  ["max-results N · margin M · ignore NAME · unseen ignore|report|block", "options, in any order, at the end"],
];

export const examples: readonly string[] = [
  "distance sphere 0.05 at 0.5 0 1", "contacts box 0.1 0.1 0.2 at 0.5 0 1", "check object mug at 0.5 0.1 0.2",
  "ray from 0 0 1 direction 1 0 -0.3"];

// Words are typed by users: "constructor" must not match an inherited property.
function entry<Value>(record: Record<string, Value>, key: string): Value | undefined {
  return Object.hasOwn(record, key) ? record[key] : undefined;
}

// The words of a text; a name with spaces stands in quotes.
function wordsOf(text: string): string[] {
  const words = text.match(/"[^"]*"|[^\s,=]+/g) ?? [];
  return words.map((word) => word.replace(/^--(?=[a-z])/, "").replace(/^"(.*)"$/, "$1"));
}

class Words {
  private at = 0;
  constructor(private readonly words: readonly string[]) {}

  get next(): string | undefined { return this.words[this.at]; }
  take(): string | undefined { return this.words[this.at++]; }

  name(of: string): string {
    const word = this.take();
    if (word === undefined) throw new QueryError(`${of}: a name is missing`);
    return word;
  }

  isNumber(): boolean { return this.next !== undefined && this.next !== "" && Number.isFinite(Number(this.next)); }

  numbers(of: string, fields: readonly string[]): number[] {
    return fields.map((field) => {
      if (!this.isNumber()) {
        const found = this.next === undefined ? "nothing" : `"${this.next}"`;
        throw new QueryError(`${of}: ${field} must be a number, found ${found}; ${of} takes ${fields.join(" ")}`);
      }
      return Number(this.take());
    });
  }

  count(of: string): number {
    const [value = 0] = this.numbers(of, ["N"]);
    if (!Number.isInteger(value) || value < 1) throw new QueryError(`${of}: N must be 1, 2, ..., found ${value}`);
    return Math.min(value, 2 ** 31 - 1);
  }
}

interface Parts {
  shape?: ShapeOneOf;
  object?: string;
  robot?: string;
  at?: Pose;
  from?: number[];
  direction?: number[];
  to?: number[];
  options: Json;
}

// The server refuses invalid rotations; a zero quaternion means the identity.
function readPose(words: Words): Pose {
  const [tx_m = 0, ty_m = 0, tz_m = 0] = words.numbers("at", ["X", "Y", "Z"]);
  const turned = words.isNumber();
  const [qx = 0, qy = 0, qz = 0, qw = 1] = turned ? words.numbers("at X Y Z", ["QX", "QY", "QZ", "QW"]) : [];
  if (turned && Math.abs(Math.hypot(qx, qy, qz, qw) - 1) > 1e-3) {
    throw new QueryError("at: the quaternion QX QY QZ QW must be of length 1");
  }
  return { tx_m, ty_m, tz_m, qx, qy, qz, qw };
}

const optionReaders: Record<string, (words: Words, options: Json) => void> = {
  "max-results": (words, options) => { options["max_results"] = words.count("max-results"); },
  "max-contacts": (words, options) => { options["max_contacts"] = words.count("max-contacts"); },
  "max-distance": (words, options) => { [options["max_distance_m"]] = words.numbers("max-distance", ["M"]); },
  margin: (words, options) => { [options["margin_m"]] = words.numbers("margin", ["M"]); },
  ignore: (words, options) => {
    options["ignore"] = [...(options["ignore"] as string[] | undefined ?? []), words.name("ignore")];
  },
  unseen: (words, options) => {
    const word = words.name("unseen");
    if (!["ignore", "report", "block"].includes(word)) {
      throw new QueryError(`unseen: must be ignore, report or block, found "${word}"`);
    }
    options["unseen"] = `UNSEEN_SPACE_${word.toUpperCase()}`;
  },
};

function readPart(words: Words, parts: Parts): void {
  const word = words.take() ?? "";
  const shape = entry(shapes, word);
  const option = entry(optionReaders, word);
  if (shape) {
    if (parts.shape) throw new QueryError(`${word}: only one shape at a time`);
    parts.shape = shape.make(words.numbers(word, shape.fields));
  } else if (option) option(words, parts.options);
  else if (word === "object" || word === "robot") parts[word] = words.name(word);
  else if (word === "at") parts.at = readPose(words);
  else if (word === "from" || word === "direction" || word === "to") parts[word] = words.numbers(word, ["X", "Y", "Z"]);
  else throw new QueryError(`"${word}" is no word of a question; press ? for all of them`);
}

const base64 = (numbers: readonly number[]): string => {
  const bytes = new Uint8Array(new Float64Array(numbers).buffer);
  return btoa(String.fromCharCode(...bytes));
};

const rows = (numbers: readonly number[]): Json => ({ scalar: "SCALAR_F64", data: base64(numbers) });

const poseNumbers = (at: Pose): number[] => [at.tx_m, at.ty_m, at.tz_m, at.qx, at.qy, at.qz, at.qw];

function rayQuery(parts: Parts, options: Json): Query {
  const { from, direction, to } = parts;
  if (!from) throw new QueryError("ray: from X Y Z is missing");
  if ((direction === undefined) === (to === undefined)) {
    throw new QueryError("ray: takes one of direction X Y Z and to X Y Z");
  }
  const along = direction ?? to?.map((value, i) => value - (from[i] ?? 0)) ?? [];
  if (Math.hypot(...along) === 0) throw new QueryError("ray: its direction must not be zero");
  return { kind: "ray", method: methods.ray, request: { rays: rows([...from, ...along]), options },
           ray: { from, direction: along } };
}

function subjectOf(kind: QueryKind, { shape, object, robot, at }: Parts): Json {
  if ([shape, object, robot].filter((one) => one !== undefined).length !== 1) {
    throw new QueryError(`${kind}: takes one shape, object NAME or robot NAME`);
  }
  if (shape) {
    if (!at) throw new QueryError(`${kind}: at X Y Z is missing, where the shape is`);
    return { shapes: { shapes: [shape], x_world_body: rows(poseNumbers(at)) } };
  }
  if (object !== undefined) return { object: { name: object, ...(at && { x_world_object: rows(poseNumbers(at)) }) } };
  return { robot: { robot, ...(at && { x_world_base: at }) } };
}

// Throws a QueryError.
export function parseQuery(text: string): Query {
  const all = wordsOf(text);
  if (all[0] === "cwm") all.shift();  // copied from a shell
  const words = new Words(all);
  const kind = words.take() ?? "";
  if (!Object.hasOwn(methods, kind)) {
    throw new QueryError(`a question begins with distance, contacts, check or ray, not with "${kind}"`);
  }
  const parts: Parts = { options: { result_form: "RESULT_FORM_ROWS", scalar: "SCALAR_F64" } };
  while (words.next !== undefined) readPart(words, parts);
  if (kind === "ray") return rayQuery(parts, parts.options);
  const query: Query = {
    kind: kind as QueryKind, method: methods[kind as QueryKind],
    request: { subject: subjectOf(kind as QueryKind, parts), options: parts.options } };
  if (parts.shape && parts.at) query.subject = { shape: parts.shape, at: parts.at };
  if (parts.object !== undefined) query.object = parts.object;
  return query;
}
