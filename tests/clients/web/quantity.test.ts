import assert from "node:assert/strict";
import { test } from "node:test";
import { count, fixed, mm, percent, plural } from "../../../clients/web/src/page/quantity";
import { coefficients, dimensions, rotation, shapeName } from "../../../clients/web/src/page/shape_text";
import type { ShapePart } from "../../../clients/web/src/world/types";

test("numbers keep their decimals, and a zero has no sign", () => {
  assert.equal(fixed(-1.25, 1), "\u22121.3");
  assert.equal(fixed(-0.0001, 3), "0.000");
  assert.equal(mm(0.0331), "33.1");
  assert.equal(percent(0.9995, 2), "99.95");
});

test("counts are grouped by thousands", () => {
  assert.equal(count("307200"), "307\u2009200");
  assert.equal(count(999), "999");
  assert.equal(plural(1, "note"), "1 note");
});

const cylinder: ShapePart = {
  cylinder: { radius_m: 0.0327, length_m: 0.1221 }, role: "PART_ROLE_FITTED",
  coefficients: [0.1, 0.2, 0.3, 0, 0, 1, 0.0327],
  fit: { rms_m: 0.001, max_residual_m: 0.004, inlier_count: "900", inlier_ratio: 0.9, observed_fraction: 0.5,
         parameter_sigma: [0.0001, 0.0002, 0.0003, 0.01, 0.02, 0.03, 0.0004] } };

test("a cylinder is told by its radius and its length", () => {
  assert.equal(dimensions(cylinder), "r 32.7, l 122.1");
});

test("coefficients have PCL's names, and deviations the unit that fits them", () => {
  const all = coefficients(cylinder);
  assert.deepEqual(all.map(({ name }) => name), [
    "point on axis x", "point on axis y", "point on axis z", "axis x", "axis y", "axis z", "radius"]);
  assert.deepEqual(all.map(({ symbol }) => symbol), ["x", "y", "z", "a_x", "a_y", "a_z", "r"]);
  assert.equal(all[6]?.value, "0.0327");
  assert.equal(all[6]?.sigma, "± 0.40 mm");
  assert.equal(all[3]?.sigma, "± 0.0100");
});

const vessel: ShapePart = {
  mesh: { hash: "ab" }, role: "PART_ROLE_FITTED", coefficients: [],
  vessel: { rim_radius_m: 0.0412, foot_radius_m: 0.0363, height_m: 0.095, depth_m: 0.09, wall_thickness_m: 0.004,
            rim_radius_sigma_m: 0.0008 } };

test("a vessel is told by its radii, its height, and what a grasp asks of it", () => {
  assert.equal(shapeName(vessel), "vessel");
  assert.equal(dimensions(vessel), "r 36.3 to 41.2, h 95.0");
  const all = coefficients(vessel);
  assert.deepEqual(all.map(({ name }) => name), ["rim radius", "foot radius", "height", "depth", "wall"]);
  assert.deepEqual(all.map(({ symbol }) => symbol), ["r_rim", "r_foot", "h", "depth", "wall"]);
  assert.equal(all[0]?.value, "0.0412");
  assert.equal(all[0]?.sigma, "± 0.80 mm");
  assert.equal(all[4]?.sigma, "");
});

test("an unknown deviation is left out", () => {
  const { fit, ...rest } = cylinder;
  assert.ok(coefficients({ ...rest, fit: { ...(fit as NonNullable<typeof fit>), parameter_sigma: [] } })
    .every(({ sigma }) => sigma === ""));
});

test("a rotation is an angle about an axis, and none is silence", () => {
  const half = Math.SQRT1_2;
  assert.equal(rotation({ tx_m: 0, ty_m: 0, tz_m: 0, qx: 0, qy: 0, qz: -half, qw: -half }), "90.0° about 0.00 0.00 1.00");
  assert.equal(rotation({ tx_m: 1, ty_m: 0, tz_m: 0, qx: 0, qy: 0, qz: 0, qw: 1 }), "");
});
