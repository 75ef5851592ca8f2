// Draws a result: the bodies of the query where it places them, lines between nearest points,
// contacts with their normals, and boxes around what collides.
import { Box3, Matrix4, Quaternion, Vector3 } from "three";
import type { Pose, Vector3 as ApiVector3 } from "../../world/types";
import { matrixOf } from "../../scene/pose";
import type { MarkedLink, QueryResult } from "../query_result";
import type { Query } from "../query";
import type { RobotGhosts } from "../robot_ghosts";
import { isRobot, type SceneObject } from "../scene_objects";
import type { Label } from "./labels";
import { arrowSegments, boxSegments, type Segment } from "./lines";
import { shapeParts, type Part } from "./parts";
import type { DrawnObject } from "./world_view";

const freeColor = "#1f8fff";
const touchColor = "#e5383b";

export interface ResultPicture { bodies: readonly DrawnObject[]; segments: Segment[]; labels: Label[]; }

// What a result is drawn beside.
export interface ResultScene {
  objects: ReadonlyMap<string, SceneObject>;
  ghosts: RobotGhosts;  // of the robot that was asked about; empty: where it stands
  boundsOf: (name: string) => Box3;  // of a drawn object, in the world
  frameBounds: (drawn: DrawnObject, frame: number) => Box3;  // of an object's parts in a frame of it
}

const bodyPrefix = "\u0000question";  // no object's name can begin so

export const isBody = (name: string): boolean => name.startsWith(bodyPrefix);

const vector = ({ x, y, z }: ApiVector3): Vector3 => new Vector3(x, y, z);

// Three short strokes: a point, seen from anywhere.
function crossSegments(at: Vector3, size_m: number, color: string): Segment[] {
  return [0, 1, 2].map((axis) => {
    const arm = new Vector3().setComponent(axis, size_m);
    return { from: at.clone().sub(arm), to: at.clone().add(arm), color };
  });
}

// Positions linearly and rotations by slerp, as motions go.
function poseBetween(from: Pose, to: Pose, share: number): Pose {
  const mixed = (a: number, b: number): number => a + share * (b - a);
  const turned = ({ qx, qy, qz, qw }: Pose): Quaternion => new Quaternion(qx, qy, qz, qw).normalize();
  const { x: qx, y: qy, z: qz, w: qw } = turned(from).slerp(turned(to), share);
  return { tx_m: mixed(from.tx_m, to.tx_m), ty_m: mixed(from.ty_m, to.ty_m), tz_m: mixed(from.tz_m, to.tz_m), qx, qy, qz, qw };
}

// The given places, and where a motion stops.
function placesOf({ at }: Query, stop: QueryResult["stop"]): Matrix4[] {
  const from = stop && at[stop.segment];
  const to = stop && at[stop.segment + 1];
  return [...at, ...(stop && from && to ? [poseBetween(from, to, stop.share)] : [])].map(matrixOf);
}

function ghostOf(index: number, color: string, frames: readonly Matrix4[], parts: readonly { frame: number; part: Part }[],
                 shape: string): DrawnObject {
  return { name: `${bodyPrefix} ${index}`, color, shape, frames,
           parts: parts.map(({ frame, part }) => ({ frame, part: { ...part, appearance: "ghost" } })) };
}

// The bodies of a query at all its places; none for what stands where it is drawn already.
export function bodiesOf(query: Query, verdict: QueryResult["verdict"] | "asked", scene: Pick<ResultScene, "objects" | "ghosts">,
                         stop?: QueryResult["stop"]): DrawnObject[] {
  const { shape, robot } = query;
  const colorOf = (i: number, count: number): string => {
    const isBefore = query.kind === "motion" && !(stop && i === count - 1);  // the place where it stops is the last
    return verdict === "collision" && !isBefore ? touchColor : freeColor;
  };
  if (robot) {
    const drawn = scene.objects.get(robot.name);
    if (!drawn || !isRobot(drawn.source)) return [];
    const { links } = drawn.source;
    return scene.ghosts.map((poses, i, { length }) => ghostOf(i, colorOf(i, length), links.map(({ link, x_world_link }) => poses.get(link) ?? matrixOf(x_world_link)),
                                                               drawn.drawn.parts, `${drawn.drawn.shape} ghost`));
  }
  const places = placesOf(query, stop);
  const parts = shape ? shapeParts({ ...shape, role: "", coefficients: [] }, "shapes").map((part) => ({ frame: 0, part }))
    : scene.objects.get(query.object ?? "")?.drawn.parts ?? [];
  const key = shape ? JSON.stringify(shape) : `${scene.objects.get(query.object ?? "")?.drawn.shape} ghost`;
  return places.map((X, i) => ghostOf(i, colorOf(i, places.length), [X], parts, key));
}

// The way of a body's origin.
function pathSegments({ at }: Query): Segment[] {
  const points = at.map(({ tx_m, ty_m, tz_m }) => new Vector3(tx_m, ty_m, tz_m));
  return points.slice(1).map((to, i) => ({ from: points[i] as Vector3, to, color: freeColor }));
}

// A box around each link that touches something, with its name.
function linkMarks(query: Query, links: readonly MarkedLink[], scene: ResultScene): Pick<ResultPicture, "segments" | "labels"> {
  const segments: Segment[] = [];
  const labels: Label[] = [];
  for (const { robot, link, row } of links) {
    const drawn = scene.objects.get(robot === "" ? query.robot?.name ?? "" : robot);
    if (!drawn || !isRobot(drawn.source)) continue;
    const frame = drawn.source.links.findIndex((one) => one.link === link);
    const X = (robot === "" ? scene.ghosts.at(row)?.get(link) : undefined) ?? drawn.drawn.frames[frame];
    const bounds = scene.frameBounds(drawn.drawn, frame);
    if (!X || bounds.isEmpty()) continue;
    segments.push(...boxSegments(bounds, X, touchColor));
    labels.push({ text: link, at: bounds.getCenter(new Vector3()).applyMatrix4(X), kind: "mark" });
  }
  return { segments, labels };
}

function objectMarks(names: readonly string[], scene: ResultScene): Pick<ResultPicture, "segments" | "labels"> {
  const seen = names.map((name) => ({ name, bounds: scene.boundsOf(name) })).filter(({ bounds }) => !bounds.isEmpty());
  return {
    segments: seen.flatMap(({ bounds }) => boxSegments(bounds, new Matrix4(), touchColor)),
    labels: seen.map(({ name, bounds }) => ({ text: name, at: bounds.getCenter(new Vector3()).setZ(bounds.max.z), kind: "mark" })) };
}

// `scale_m`, the length of strokes, is about a twentieth of the picture's extent.
export function resultPicture(query: Query, result: QueryResult, scale_m: number, scene: ResultScene): ResultPicture {
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
  if (query.kind === "motion") segments.push(...pathSegments(query));
  const links = linkMarks(query, result.links, scene);
  const objects = objectMarks(result.touched, scene);
  return { bodies: bodiesOf(query, result.verdict, scene, result.stop), segments: [...segments, ...links.segments, ...objects.segments],
           labels: [...labels, ...links.labels, ...objects.labels] };
}
