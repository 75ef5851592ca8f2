// Shapes and their coefficients in words and numbers.
import type { Pose, ShapePart, Vessel } from "../world/types";
import { kindOf } from "../world/types";
import { degrees, fixed, mm } from "./quantity";

const times = "\u2009×\u2009";

export function shapeName(part: ShapePart): string {
  if (part.vessel) return "vessel";
  return (kindOf(part) ?? "").replace("_", " ");
}

// In millimetres: "⌀" would hide which radius is meant, so radii are named.
export function dimensions(part: ShapePart): string {
  if (part.sphere) return `r ${mm(part.sphere.radius_m)}`;
  if (part.box) return [part.box.size_x_m, part.box.size_y_m, part.box.size_z_m].map((m) => mm(m)).join(times);
  if (part.cylinder) return `r ${mm(part.cylinder.radius_m)}, l ${mm(part.cylinder.length_m)}`;
  if (part.cone) {
    return `r ${mm(part.cone.radius_bottom_m)} to ${mm(part.cone.radius_top_m)}, l ${mm(part.cone.length_m)}`;
  }
  if (part.capsule) return `r ${mm(part.capsule.radius_m)}, l ${mm(part.capsule.length_m)}`;
  if (part.plate) {
    const holes = part.plate.holes.length;
    const holesText = holes === 0 ? "" : `, ${holes} hole${holes === 1 ? "" : "s"}`;
    return `${part.plate.outline.vertices.length} corners${holesText}, ${mm(part.plate.thickness_m)} thick`;
  }
  if (part.vessel) {
    const { foot_radius_m: foot, rim_radius_m: rim, height_m: height } = part.vessel;
    return `r ${mm(foot)} to ${mm(rim)}, h ${mm(height)}`;
  }
  return "";
}

export interface Coefficient {
  name: string;    // "axis x"
  symbol: string;  // "a_x"
  value: string;
  sigma: string;  // empty: unknown
  unit: string;
  exact: number;
}

type Quantity = "length" | "direction" | "angle";
type Named = readonly [name: string, symbol: string, quantity: Quantity];

// Three coefficients along the axes: "centre x" with the symbol "x", or "axis x" with "a_x".
const vector = (name: string, letter: string, quantity: Quantity): readonly Named[] =>
  ["x", "y", "z"].map((along) => [`${name} ${along}`, letter === "" ? along : `${letter}_${along}`, quantity]);

// In PCL's order (coefficients.h of the server).
const plane: readonly Named[] = [...vector("normal", "n", "direction"), ["d", "d", "length"]];
const axis = vector("axis", "a", "direction");
const radius: Named = ["radius", "r", "length"];
const layouts: Record<string, readonly Named[]> = {
  plate: plane,
  half_space: plane,
  sphere: [...vector("centre", "", "length"), radius],
  cylinder: [...vector("point on axis", "", "length"), ...axis, radius],
  cone: [...vector("apex", "", "length"), ...axis, ["half angle", "angle", "angle"]],
  box: vector("size", "s", "length"),  // PCL has none: its sizes
};

function write(value: number, quantity: Quantity): string {
  if (quantity === "angle") return degrees(value);
  return fixed(value, 4);
}

function writeSigma(sigma: number | undefined, quantity: Quantity): string {
  if (sigma === undefined || sigma === 0) return "";  // 0: fixed, or not observed
  if (quantity === "length") return `± ${mm(sigma, 2)} mm`;
  return quantity === "angle" ? `± ${degrees(sigma)}°` : `± ${fixed(sigma, 4)}`;
}

const units: Record<Quantity, string> = { length: "m", direction: "", angle: "°" };

// The parameters that parameter_sigma refers to.
function parameters(part: ShapePart): readonly number[] {
  const { box, fit } = part;
  return box && fit?.parameter_sigma.length ? [box.size_x_m, box.size_y_m, box.size_z_m] : part.coefficients;
}

// PCL has no model of a vessel, so these are the values that a grasp planner needs.
function ofVessel(vessel: Vessel): Coefficient[] {
  const all: readonly (readonly [name: string, symbol: string, exact: number, sigma?: number | undefined])[] = [
    ["rim radius", "r_rim", vessel.rim_radius_m, vessel.rim_radius_sigma_m],
    ["foot radius", "r_foot", vessel.foot_radius_m], ["height", "h", vessel.height_m], ["depth", "depth", vessel.depth_m],
    ["wall", "wall", vessel.wall_thickness_m, vessel.wall_thickness_sigma_m]];
  return all.map(([name, symbol, exact, sigma]) => ({
    name, symbol, exact, unit: units.length, value: write(exact, "length"), sigma: writeSigma(sigma, "length"),
  }));
}

export function coefficients(part: ShapePart): Coefficient[] {
  if (part.vessel) return ofVessel(part.vessel);
  const layout = layouts[kindOf(part) ?? ""] ?? [];
  return parameters(part).map((exact, i) => {
    const [name, symbol, quantity] = layout[i] ?? [`coefficient ${i + 1}`, `c_${i + 1}`, "direction" as Quantity];
    return {
      name, symbol, exact, unit: units[quantity], value: write(exact, quantity),
      sigma: writeSigma(part.fit?.parameter_sigma[i], quantity),
    };
  });
}

export const position = (pose: Pose): string[] => [pose.tx_m, pose.ty_m, pose.tz_m].map((m) => fixed(m, 3));

// A smaller rotation is printed as 0.0 degrees.
const minTurn_rad = 8e-4;

// "30.0° about 0.00 0.00 1.00"; empty if there is no rotation.
export function rotation(pose: Pose): string {
  const sine = Math.hypot(pose.qx, pose.qy, pose.qz);
  const angle_rad = 2 * Math.atan2(sine, Math.abs(pose.qw));
  if (angle_rad < minTurn_rad) return "";
  const scale = (pose.qw < 0 ? -1 : 1) / sine;
  const axis = [pose.qx, pose.qy, pose.qz].map((q) => fixed(scale * q, 2)).join(" ");
  return `${degrees(angle_rad, 1)}° about ${axis}`;
}
