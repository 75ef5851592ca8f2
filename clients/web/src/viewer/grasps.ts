// Reads and checks the grasps of `cwm-grasp --json`, ranks them over all objects, and checks
// whether they still hold in the displayed world. Pure: no picture, no page.
import type { Pose, WorldObject } from "../world/types";
import type { WorldState } from "./world_model";

type Triple = readonly [number, number, number];

// In the frame of a grasp: z is the approach, x the closing direction.
export interface GripperBox { centre: Triple; size_m: Triple; }

export interface GraspContact { point: Triple; normal: Triple; }

export interface Grasp {
  rank: number;  // 1 is the best over all objects
  isBest: boolean;  // the best of its object
  object: string;
  way: string;
  score: number;  // 0 to 1
  width_m: number;
  clearance_m: number;
  x_world_grasp: Pose;
  x_world_pregrasp: Pose;
  contacts: readonly GraspContact[];
}

export interface GraspPlan {
  world: string;
  world_uid: string;
  revision: number;
  opening_m: number;
  boxes: readonly GripperBox[];
  grasps: readonly Grasp[];  // the best first
  graspless: readonly { object: string; why: string }[];
}

// The message has the field at fault, its value and the rule.
export class GraspFileError extends Error {}

const maxBytes = 64 << 20;
const maxGrasps = 20_000;
const maxBoxes = 64;
const unitSlack = 1e-3;

// A value of the document with its path.
class Field {
  constructor(private readonly value: unknown, private readonly path: string) {}

  fail(rule: string): never {
    const text = this.value === undefined ? "is missing" : `is ${this.shown()}`;
    throw new GraspFileError(`${this.path || "the file"} ${text}: ${rule}`);
  }

  private shown(): string {
    const text = JSON.stringify(this.value) ?? String(this.value);
    return text.length > 40 ? `${text.slice(0, 40)}\u2026` : text;
  }

  get(key: string): Field {
    if (typeof this.value !== "object" || this.value === null || Array.isArray(this.value)) this.fail("it must be an object");
    const inside: unknown = Object.hasOwn(this.value, key) ? (this.value as Record<string, unknown>)[key] : undefined;
    return new Field(inside, this.path === "" ? key : `${this.path}.${key}`);
  }

  list(most: number): Field[] {
    if (!Array.isArray(this.value)) return this.fail("it must be a list");
    if (this.value.length > most) throw new GraspFileError(`${this.path} has ${this.value.length} entries: at most ${most} are drawn`);
    return this.value.map((value: unknown, i) => new Field(value, `${this.path}[${i}]`));
  }

  number(least = -Infinity, most = Infinity): number {
    const { value } = this;
    if (typeof value !== "number" || !Number.isFinite(value)) return this.fail("it must be a number");
    if (value < least) this.fail(`it must be at least ${least}`);
    if (value > most) this.fail(`it must be at most ${most}`);
    return value;
  }

  text(): string { return typeof this.value === "string" ? this.value : this.fail("it must be a text"); }

  triple(least = -Infinity): Triple {
    const all = this.list(3);
    if (all.length !== 3) this.fail("it must be three numbers");
    return all.map((field) => field.number(least)) as unknown as Triple;
  }

  pose(): Pose {
    const of = (name: string): number => this.get(name).number();
    const pose = { tx_m: of("tx_m"), ty_m: of("ty_m"), tz_m: of("tz_m"), qx: of("qx"), qy: of("qy"), qz: of("qz"), qw: of("qw") };
    const norm = Math.hypot(pose.qx, pose.qy, pose.qz, pose.qw);
    if (Math.abs(norm - 1) > unitSlack) {
      throw new GraspFileError(`${this.path} has a quaternion of length ${norm.toPrecision(4)}: it must be 1`);
    }
    return pose;
  }
}

function graspOf(field: Field, object: string): Omit<Grasp, "rank" | "isBest"> {
  return {
    object, way: field.get("way").text(), score: field.get("score").number(0, 1), width_m: field.get("width_m").number(0),
    clearance_m: field.get("clearance_m").number(), x_world_grasp: field.get("x_world_grasp").pose(),
    x_world_pregrasp: field.get("x_world_pregrasp").pose(),
    contacts: field.get("contacts").list(2).map((contact) =>
      ({ point: contact.get("point").triple(), normal: contact.get("normal").triple() })) };
}

function parsed(text: string): Field {
  try {
    return new Field(JSON.parse(text), "");
  } catch (error) {
    throw new GraspFileError(`it is no JSON: ${error instanceof Error ? error.message : String(error)}`);
  }
}

export function checkSize(bytes: number): void {
  if (bytes > maxBytes) throw new GraspFileError(`it has ${(bytes / 1e6).toFixed(0)} MB: at most ${maxBytes >> 20} MiB are read`);
}

// Throws GraspFileError.
export function parseGrasps(text: string): GraspPlan {
  const root = parsed(text);
  const gripper = root.get("gripper");
  const found: Omit<Grasp, "rank" | "isBest">[] = [];
  const graspless: { object: string; why: string }[] = [];
  for (const field of root.get("objects").list(maxGrasps)) {
    const object = field.get("name").text();
    const grasps = field.get("grasps").list(maxGrasps).map((grasp) => graspOf(grasp, object));
    if (grasps.length === 0) graspless.push({ object, why: field.get("why").text() });
    for (const grasp of grasps) found.push(grasp);
    if (found.length > maxGrasps) throw new GraspFileError(`objects have ${found.length} grasps together: at most ${maxGrasps} are drawn`);
  }
  found.sort((a, b) => b.score - a.score);
  const taken = new Set<string>();
  const grasps = found.map((grasp, i) => {
    const isBest = !taken.has(grasp.object);
    taken.add(grasp.object);
    return { ...grasp, rank: i + 1, isBest };
  });
  return {
    world: root.get("world").text(), world_uid: root.get("world_uid").text(), revision: root.get("revision").number(0),
    opening_m: gripper.get("opening_m").number(0), grasps, graspless,
    boxes: gripper.get("boxes").list(maxBoxes).map((box) =>
      ({ centre: box.get("centre").triple(), size_m: box.get("size_m").triple(0) })) };
}

// Columns of the rotation of a pose: the closing direction and the approach of a grasp.
function axesOf({ qx, qy, qz, qw }: Pose): { closing: Triple; approach: Triple } {
  return { closing: [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + qz * qw), 2 * (qx * qz - qy * qw)],
           approach: [2 * (qx * qz + qy * qw), 2 * (qy * qz - qx * qw), 1 - 2 * (qx * qx + qy * qy)] };
}

const degrees = (angle_rad: number): number => Math.round((angle_rad * 180) / Math.PI);

// The azimuth of a direction about the world's z in whole degrees, below `turn_deg`.
const azimuth_deg = ([x, y]: Triple, turn_deg: number): number => (degrees(Math.atan2(y, x)) + 360) % turn_deg;

// chosen: within some degrees of upright an azimuth says nothing.
const upright = 0.995;

// Where the gripper comes from and along which direction it closes: grasps of one object differ in
// these or in their place. "from above, closing along 40\u00b0", angles about the world's z from x.
export function directionText({ x_world_grasp }: Grasp): string {
  const { closing, approach } = axesOf(x_world_grasp);
  const down_deg = degrees(Math.asin(Math.min(Math.max(-approach[2], -1), 1)));
  const from = approach[2] < -upright ? "from above" : approach[2] > upright ? "from below"
    : `towards ${azimuth_deg(approach, 360)}\u00b0, ${Math.abs(down_deg)}\u00b0 ${down_deg < 0 ? "up" : "down"}`;
  return `${from}, closing ${Math.abs(closing[2]) > upright ? "upright" : `along ${azimuth_deg(closing, 180)}\u00b0`}`;
}

function changeSince(revision: number, object: WorldObject): string {
  if (Number(object.create_revision) > revision) return "another object now";
  if (Number(object.geometry_revision) > revision) return "reshaped since";
  return Number(object.pose_revision) > revision ? "moved since" : "";
}

// The reason why a grasp of this object is stale in this state; empty if it is valid.
export function staleness({ world_uid, revision }: GraspPlan, object: string, state: WorldState): string {
  if (state.world_uid !== world_uid) return "another world";
  const now = state.objects.get(object);
  return now ? changeSince(revision, now) : "gone";
}

// The reason why the whole plan is invalid; empty if it is for the displayed world.
export function planWarning({ world, world_uid, revision }: GraspPlan, state: WorldState): string {
  if (state.world_uid !== world_uid) return `Planned in a world \u201c${world}\u201d that is not the one shown.`;
  if (Number(state.revision) === revision) return "";
  return `Planned at revision ${revision}, shown is ${state.revision}: other things may be in the way now.`;
}

const stops: readonly Triple[] = [[200, 40, 50], [232, 160, 0], [0, 170, 130], [20, 90, 220]];

// From red by amber and green to blue, the best; never near the grey of stale grasps.
export function scoreColor(score: number): string {
  const at = Math.min(Math.max(score, 0), 1) * (stops.length - 1);
  const low = Math.min(Math.floor(at), stops.length - 2);
  const [from, to] = [stops[low] as Triple, stops[low + 1] as Triple];
  const channels = from.map((value, i) => Math.round(value + (at - low) * ((to[i] as number) - value)));
  return `#${channels.map((value) => value.toString(16).padStart(2, "0")).join("")}`;
}
