// The scan's points as three.js takes them: a geometry for each run, placed by the sensor's pose.
import { BufferAttribute, BufferGeometry } from "three";
import { bytesOf } from "../scene/mesh_geometry";
import type { PackedPoints, PointRun } from "./record";

export interface RunGeometry { run: PointRun; geometry: BufferGeometry; }

export function runGeometries(points: PackedPoints): RunGeometry[] {
  const grid = new Uint16Array(bytesOf(points.grid));
  let first = 0;
  return points.runs.map((run) => {
    const position = new Float32Array(3 * run.count);
    for (let i = 0; i < position.length; ++i) {
      position[i] = (points.origin_m[i % 3] as number) + points.step_m * (grid[first + i] as number);
    }
    first += position.length;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(position, 3));
    return { run, geometry };
  });
}
