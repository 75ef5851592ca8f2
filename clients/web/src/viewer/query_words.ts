// The words of a typed query: names, numbers and places, read one after another. Pure.
import type { Robot } from "../world/stream";
import type { Pose, Vector3 } from "../world/types";

// The message is a sentence about the error in the text.
export class QueryError extends Error {}

// What a query may refer to: the displayed state of the world.
export interface QueryWorld {
  centreOf: (object: string) => Vector3 | undefined;  // of its bounding box, else its origin
  robot: (name: string) => Robot | undefined;
}

// `plus` is the index of the first plus outside quotes, or -1.
interface Word { text: string; isQuoted: boolean; plus: number; }

function wordOf(raw: string): Word {
  let [text, plus, isInside] = ["", -1, false];
  for (const letter of raw) {
    if (letter === '"') isInside = !isInside;
    else {
      if (letter === "+" && !isInside && plus < 0) plus = text.length;
      text += letter;
    }
  }
  return { text, isQuoted: raw.includes('"'), plus };
}

export class Words {
  private readonly words: readonly Word[];
  private at = 0;

  // Words are separated by spaces, commas and equals signs; options may have their dashes; a name
  // with spaces stands in quotes.
  constructor(text: string, private readonly world: QueryWorld) {
    this.words = (text.match(/(?:"[^"]*"|[^\s,="])+/g) ?? []).map((raw) => wordOf(raw.replace(/^--(?=[a-z])/, "")));
  }

  get next(): string | undefined { return this.words[this.at]?.text; }
  get isQuoted(): boolean { return this.words[this.at]?.isQuoted ?? false; }
  take(): string | undefined { return this.words[this.at++]?.text; }

  name(of: string): string {
    const word = this.take();
    if (word === undefined) throw new QueryError(`${of}: a name is missing`);
    return word;
  }

  isNumber(): boolean { return !this.isQuoted && this.next !== undefined && this.next !== "" && Number.isFinite(Number(this.next)); }

  numbers(of: string, fields: readonly string[]): number[] {
    return fields.map((field) => {
      if (!this.isNumber()) {
        const found = this.next === undefined ? "nothing" : `"${this.next}"`;
        throw new QueryError(`${of}: ${field} must be a number, found ${found}; ${of} takes ${fields.join(" ")}`);
      }
      return Number(this.take());
    });
  }

  // All numbers up to the next word.
  row(): number[] {
    const row: number[] = [];
    while (this.isNumber()) row.push(Number(this.take()));
    return row;
  }

  count(of: string): number {
    const [value = 0] = this.numbers(of, ["N"]);
    if (!Number.isInteger(value) || value < 1) throw new QueryError(`${of}: N must be 1, 2, ..., found ${value}`);
    return Math.min(value, 2 ** 31 - 1);
  }

  oneOf(of: string, choices: readonly string[]): string {
    const word = this.name(of);
    if (!choices.includes(word)) {
      throw new QueryError(`${of}: must be ${choices.slice(0, -1).join(", ")} or ${choices.at(-1)}, found "${word}"`);
    }
    return word;
  }

  // "X Y Z", or "NAME" or "NAME+DX,DY,DZ": the centre of an object, moved along the world's axes.
  point(of: string): number[] {
    if (this.isNumber() || this.next === undefined) return this.numbers(of, ["X", "Y", "Z"]);
    const { text, plus } = this.words[this.at++] as Word;
    const name = plus > 0 ? text.slice(0, plus) : text;
    const centre = this.world.centreOf(name);
    if (!centre) throw new QueryError(`${of}: there is no object "${name}" in this world`);
    const offset = this.offset(of, plus > 0 ? text.slice(plus + 1) : undefined);
    return [centre.x, centre.y, centre.z].map((value, i) => value + (offset[i] ?? 0));
  }

  // A point, and after numbers perhaps a rotation. The server refuses invalid rotations; a zero
  // quaternion means the identity.
  pose(of: string): Pose {
    const isNumbers = this.isNumber();
    const [tx_m = 0, ty_m = 0, tz_m = 0] = this.point(of);
    const isTurned = isNumbers && this.isNumber();
    const [qx = 0, qy = 0, qz = 0, qw = 1] = isTurned ? this.numbers(`${of} X Y Z`, ["QX", "QY", "QZ", "QW"]) : [];
    if (isTurned && Math.abs(Math.hypot(qx, qy, qz, qw) - 1) > 1e-3) {
      throw new QueryError(`${of}: the quaternion QX QY QZ QW must be of length 1`);
    }
    return { tx_m, ty_m, tz_m, qx, qy, qz, qw };
  }

  // `first` is what followed the plus in the name's own word; a plus may also begin the next word.
  private offset(of: string, first: string | undefined): number[] {
    const fields = ["DX", "DY", "DZ"];
    const name = `${of} NAME+DX,DY,DZ`;
    const word = this.words[this.at];
    const begins = first === undefined && word?.plus === 0 && !word.isQuoted;
    const text = begins ? (this.take() as string).slice(1) : first;
    if (text === undefined) return [0, 0, 0];
    if (text === "") return this.numbers(name, fields);
    if (!Number.isFinite(Number(text))) throw new QueryError(`${name}: DX must be a number, found "${text}"`);
    return [Number(text), ...this.numbers(name, fields.slice(1))];
  }
}
