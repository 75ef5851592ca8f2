// The drawn parts of an object as instances of batches. Pure but for three.js's matrices.
import { Matrix4, Vector3 } from "three";
import { matrixOf } from "../../scene/pose";
import { isCompleted, type Plate, type ShapeOneOf, type ShapePart, type WorldObject } from "../../world/types";
import type { Appearance } from "./appearance";
import { isStriped } from "../object_status";
import type { Unit } from "./shape_batch";

export type Layer = "shapes" | "surfaces" | "handles";

// One instance. `local` is the transform from the geometry's frame to the object's.
export interface Part {
  layer: Layer;
  appearance: Appearance;
  local: Matrix4;
  geometry:
    | { is: "unit"; unit: Unit; form: readonly [number, number] }
    | { is: "plate"; plate: Plate; face: "top" | "rest" }
    | { is: "mesh"; hash: string };
}

// Half-spaces are unbounded; they are drawn as a slab of this size.
const halfSpaceSide_m = 20;
const halfSpaceDepth_m = 1;

const thinnest = 1e-6;  // a matrix without volume has no normals

const scaled = (matrix: Matrix4, x: number, y: number, z: number): Matrix4 =>
  matrix.clone().scale(new Vector3(Math.max(x, thinnest), Math.max(y, thinnest), Math.max(z, thinnest)));

function unit(matrix: Matrix4, kind: Unit, size: readonly [number, number, number],
              form: readonly [number, number] = [1, 1]): Pick<Part, "local" | "geometry"> {
  return { local: scaled(matrix, ...size), geometry: { is: "unit", unit: kind, form } };
}

// Undefined for shapes without a simple geometry; plates are two parts.
function simplePart(shape: ShapeOneOf, matrix: Matrix4): Pick<Part, "local" | "geometry"> | undefined {
  const { sphere, box, cylinder, cone, capsule, half_space, convex, mesh } = shape;
  if (sphere) return unit(matrix, "capsule", [sphere.radius_m, sphere.radius_m, sphere.radius_m], [0, 0]);
  if (box) return unit(matrix, "box", [box.size_x_m, box.size_y_m, box.size_z_m]);
  if (cylinder) return unit(matrix, "shaft", [cylinder.radius_m, cylinder.radius_m, cylinder.length_m]);
  if (cone) {
    const widest = Math.max(cone.radius_bottom_m, cone.radius_top_m, thinnest);
    return unit(matrix, "shaft", [widest, widest, cone.length_m],
                [cone.radius_bottom_m / widest, cone.radius_top_m / widest]);
  }
  if (capsule) {
    const radius = Math.max(capsule.radius_m, thinnest);
    return unit(matrix, "capsule", [radius, radius, radius], [capsule.length_m / 2 / radius, 0]);
  }
  if (half_space) {
    const middle = matrix.clone().multiply(new Matrix4().makeTranslation(0, 0, -halfSpaceDepth_m / 2));
    return unit(middle, "box", [halfSpaceSide_m, halfSpaceSide_m, halfSpaceDepth_m]);
  }
  const hash = convex?.hash ?? mesh?.hash;
  return hash ? { local: matrix, geometry: { is: "mesh", hash } } : undefined;
}

// The top of a support's plate was measured although its body was completed.
export function shapeParts(part: ShapePart, layer: Layer, special?: Appearance): Part[] {
  const local = matrixOf(part.x_object_shape);
  const appearance: Appearance = special ?? (isCompleted(part) ? "completed" : "solid");
  if (part.plate) {
    const top: Appearance = special ?? (part.fit ? "solid" : appearance);
    const { plate } = part;
    return [{ layer, appearance: top, local, geometry: { is: "plate", plate, face: "top" } },
            { layer, appearance, local, geometry: { is: "plate", plate, face: "rest" } }];
  }
  const simple = simplePart(part, local);
  return simple ? [{ layer, appearance, ...simple }] : [];
}

// The space that no sensor saw and into which parts of the object may extend.
export function hiddenParts({ shapes }: WorldObject): Part[] {
  return shapes.flatMap(({ hidden }) => {
    if (!hidden) return [];
    const { size_x_m: x, size_y_m: y, size_z_m: z } = hidden.box;
    return [{ layer: "shapes", appearance: "unseen", ...unit(matrixOf(hidden.x_object_box), "box", [x, y, z]) }];
  });
}

const specialKinds: Record<string, Appearance> = { OBJECT_KIND_UNSEEN: "unseen", OBJECT_KIND_MOVER: "mover" };

export function partsOf(object: WorldObject): Part[] {
  const parts = plainParts(object);
  if (!isStriped(object)) return parts;
  return parts.map((part) => (part.appearance === "solid" ? { ...part, appearance: "stale" } : part));
}

function plainParts(object: WorldObject): Part[] {
  const special = specialKinds[object.kind];
  const shapes = object.shapes.flatMap((part) => shapeParts(part, "shapes", special));
  const surfaces = object.surfaces.map(({ hash }): Part => (
    { layer: "surfaces", appearance: special ?? "solid", local: new Matrix4(), geometry: { is: "mesh", hash } }));
  const handles = object.handles.map(({ hash, bounds }): Part => {
    if (hash) return { layer: "handles", appearance: "solid", local: new Matrix4(), geometry: { is: "mesh", hash } };
    const { size_x_m: x, size_y_m: y, size_z_m: z } = bounds.box;
    return { layer: "handles", appearance: "completed", ...unit(matrixOf(bounds.x_object_box), "box", [x, y, z]) };
  });
  return [...shapes, ...surfaces, ...handles];
}
