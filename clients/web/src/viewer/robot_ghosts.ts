// The states in which a query places a robot, as poses of its links. Pure but for three.js's
// matrices.
import { Matrix4 } from "three";
import { matrixOf } from "../scene/pose";
import type { LinkPoses, Robot } from "../world/stream";
import type { Json } from "./messages";
import { robotSubject, type Query } from "./query";
import type { QueryResult } from "./query_result";
import { rowBetween } from "./robot_state";

// The poses of links by name for each drawn state; the last state is where a motion stops.
export type RobotGhosts = readonly ReadonlyMap<string, Matrix4>[];

// chosen: more robots in one picture hide each other.
const maxGhosts = 12;

// Undefined if the query leaves the robot where it stands, and it is drawn there.
export function ghostRequest({ robot: asked }: Query, { stop }: QueryResult, robot: Robot | undefined, revision: string): Json | undefined {
  if (!asked || !robot || (asked.rows.length === 0 && !asked.base)) return undefined;
  const rows = asked.rows.slice(0, maxGhosts);
  if (stop) {
    const from = asked.rows[stop.segment] ?? [];
    rows.push(rowBetween(robot, asked.group, from, asked.rows[stop.segment + 1] ?? from, stop.share));
  }
  return { robot: robotSubject({ ...asked, rows }), options: { at_revision: { exact: revision }, scalar: "SCALAR_F64" } };
}

export function ghostsOf({ links, x_world_link }: LinkPoses): RobotGhosts {
  const bytes = Uint8Array.from(atob(x_world_link.data), (letter) => letter.charCodeAt(0));
  const numbers = new Float64Array(bytes.buffer);
  const width = 7 * links.length;
  return Array.from({ length: width === 0 ? 0 : Math.floor(numbers.length / width) }, (_row, row) =>
    new Map(links.map((link, k) => {
      const [tx_m = 0, ty_m = 0, tz_m = 0, qx = 0, qy = 0, qz = 0, qw = 1] = numbers.slice(row * width + 7 * k);
      return [link, matrixOf({ tx_m, ty_m, tz_m, qx, qy, qz, qw })];
    })));
}
