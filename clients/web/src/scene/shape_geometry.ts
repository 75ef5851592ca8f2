// Shapes of the world as triangles, one function for each kind, each in the shape's own frame as
// geometry.proto defines it (axis z, centred unless said otherwise).
import {
  BoxGeometry, BufferGeometry, CapsuleGeometry, CylinderGeometry, ExtrudeGeometry,
  Path, Shape, SphereGeometry, Vector2,
} from "three";
import type {
  Box, Capsule, Cone, Cylinder, Plate, Polygon, ShapeOneOf, Sphere,
} from "../world/types";

// derived: segments of a full circle. 64 chords leave 0.12 % of the radius: 0.1 mm of a mug, below
// any sensor's noise.
const circleSegments = 64;

// The same size as in the command line's tessellation.
const halfSpaceSide_m = 20;
const halfSpaceDepth_m = 1;

// The axis of three.js's round shapes is y.
const yToZ = Math.PI / 2;

export function sphereGeometry(sphere: Sphere): BufferGeometry {
  return new SphereGeometry(sphere.radius_m, circleSegments, circleSegments / 2).rotateX(yToZ);
}

export function boxGeometry(box: Box): BufferGeometry {
  return new BoxGeometry(box.size_x_m, box.size_y_m, box.size_z_m);
}

export function cylinderGeometry(cylinder: Cylinder): BufferGeometry {
  return new CylinderGeometry(
    cylinder.radius_m, cylinder.radius_m, cylinder.length_m, circleSegments).rotateX(yToZ);
}

export function coneGeometry(cone: Cone): BufferGeometry {
  return new CylinderGeometry(
    cone.radius_top_m, cone.radius_bottom_m, cone.length_m, circleSegments).rotateX(yToZ);
}

export function capsuleGeometry(capsule: Capsule): BufferGeometry {
  return new CapsuleGeometry(
    capsule.radius_m, capsule.length_m, circleSegments / 4, circleSegments).rotateX(yToZ);
}

// Solid where z <= 0, shown as a slab of limited size.
export function halfSpaceGeometry(): BufferGeometry {
  return new BoxGeometry(halfSpaceSide_m, halfSpaceSide_m, halfSpaceDepth_m)
    .translate(0, 0, -halfSpaceDepth_m / 2);
}

function pointsOf(polygon: Polygon): Vector2[] {
  return polygon.vertices.map((vertex) => new Vector2(vertex.x, vertex.y));
}

// Solid for -thickness <= z <= 0. The groups 0 and 1 are the top face, and everything else.
export function plateGeometry(plate: Plate): BufferGeometry {
  const shape = new Shape(pointsOf(plate.outline));
  shape.holes = plate.holes.map((hole) => new Path(pointsOf(hole)));
  const solid = new ExtrudeGeometry(shape, {
    depth: plate.thickness_m, bevelEnabled: false, steps: 1,
  }).translate(0, 0, -plate.thickness_m);
  return topFirst(solid);
}

// The same triangles, those of the top (z = 0, facing up) before the others, as two groups.
function topFirst(solid: BufferGeometry): BufferGeometry {
  const position = solid.getAttribute("position");
  const normal = solid.getAttribute("normal");
  const top: number[] = [];
  const rest: number[] = [];
  for (let corner = 0; corner < position.count; corner += 3) {
    const isTop = normal.getZ(corner) > 0.5;
    (isTop ? top : rest).push(corner, corner + 1, corner + 2);
  }
  solid.setIndex([...top, ...rest]);
  solid.clearGroups();
  solid.addGroup(0, top.length, 0);
  solid.addGroup(top.length, rest.length, 1);
  return solid;
}

// Finds meshes by their hash.
export type MeshSource = (hash: string) => BufferGeometry;

// Undefined for a part without a shape.
export function shapeGeometry(shape: ShapeOneOf, meshes: MeshSource): BufferGeometry | undefined {
  if (shape.sphere) return sphereGeometry(shape.sphere);
  if (shape.box) return boxGeometry(shape.box);
  if (shape.cylinder) return cylinderGeometry(shape.cylinder);
  if (shape.cone) return coneGeometry(shape.cone);
  if (shape.capsule) return capsuleGeometry(shape.capsule);
  if (shape.half_space) return halfSpaceGeometry();
  if (shape.plate) return plateGeometry(shape.plate);
  if (shape.convex) return meshes(shape.convex.hash);
  if (shape.mesh) return meshes(shape.mesh.hash);
  return undefined;
}
