// An object of the world as a group of three.js: its shapes, surfaces and handles, placed by its pose.
import {
  BufferGeometry, EdgesGeometry, Group, LineSegments, Mesh, Object3D, WireframeGeometry,
  type Material,
} from "three";
import { isCompleted, kindOf, type Handle, type ShapePart, type SurfacePart, type WorldObject }
  from "../world/types";
import { completedMaterial, edgeMaterial, solidMaterial, surfaceMaterial } from "./materials";
import { matrixOf } from "./pose";
import { boxGeometry, shapeGeometry, type MeshSource } from "./shape_geometry";

// The parts of an object that are drawn.
export interface ModelOptions {
  shapes: boolean;
  surfaces: boolean;
  triangulation: boolean;  // the edges of the meshes' triangles
  handles: "none" | "bounds" | "mesh";  // a handle without a mesh is drawn as its bounds
}

// The meaning of a drawn object3D, stored in userData.drawn.
export type Drawn =
  | { what: "shape"; kind: string; part: number; role: string }
  | { what: "surface"; hash: string; part: number }
  | { what: "handle"; hash: string; part: number };

// chosen: an edge with a smaller angle between its faces is a facet of a round shape: with 64
// segments adjacent facets differ by 5.6 degrees.
const sharpEdge_deg = 20;

const edgeOpacity = 0.55;
const triangleOpacity = 0.35;

function placed(object: Object3D, matrix = matrixOf(undefined)): Object3D {
  object.matrixAutoUpdate = false;
  object.matrix.copy(matrix);
  return object;
}

// The top of a support was measured although its body was completed.
function materialsOf(part: ShapePart, color: string): Material | Material[] {
  if (!isCompleted(part)) return part.plate ? [solidMaterial(color), solidMaterial(color)] : solidMaterial(color);
  if (!part.plate) return completedMaterial(color);
  return [part.fit ? solidMaterial(color) : completedMaterial(color), completedMaterial(color)];
}

function shapeObject(part: ShapePart, index: number, color: string, meshes: MeshSource):
    Object3D | undefined {
  const geometry = shapeGeometry(part, meshes);
  if (geometry === undefined) return undefined;
  const mesh = new Mesh(geometry, materialsOf(part, color));
  const drawn: Drawn = { what: "shape", kind: kindOf(part) ?? "", part: index, role: part.role };
  mesh.userData["drawn"] = drawn;
  mesh.add(new LineSegments(new EdgesGeometry(geometry, sharpEdge_deg), edgeMaterial(color, edgeOpacity)));
  return placed(mesh, matrixOf(part.x_object_shape));
}

function triangles(geometry: BufferGeometry, color: string): LineSegments {
  return new LineSegments(new WireframeGeometry(geometry), edgeMaterial(color, triangleOpacity));
}

function surfaceObject(surface: SurfacePart, index: number, color: string, meshes: MeshSource,
                       options: ModelOptions): Object3D {
  const geometry = meshes(surface.hash);
  const mesh = new Mesh(geometry, surfaceMaterial(color));
  const drawn: Drawn = { what: "surface", hash: surface.hash, part: index };
  mesh.userData["drawn"] = drawn;
  if (options.triangulation) mesh.add(triangles(geometry, color));
  return placed(mesh);
}

function handleObject(handle: Handle, index: number, color: string, meshes: MeshSource,
                      options: ModelOptions): Object3D {
  const drawn: Drawn = { what: "handle", hash: handle.hash, part: index };
  if (options.handles === "mesh" && handle.hash !== "") {
    const geometry = meshes(handle.hash);
    const mesh = new Mesh(geometry, surfaceMaterial(color));
    mesh.userData["drawn"] = drawn;
    if (options.triangulation) mesh.add(triangles(geometry, color));
    return placed(mesh);
  }
  const geometry = boxGeometry(handle.bounds.box);
  const mesh = new Mesh(geometry, completedMaterial(color));
  mesh.userData["drawn"] = drawn;
  mesh.add(new LineSegments(new EdgesGeometry(geometry), edgeMaterial(color, 1)));
  return placed(mesh, matrixOf(handle.bounds.x_object_box));
}

// Empty if the options exclude all parts of the object.
export function objectModel(object: WorldObject, color: string, meshes: MeshSource,
                            options: ModelOptions): Group {
  const group = new Group();
  placed(group, matrixOf(object.x_world_object));
  if (options.shapes) {
    object.shapes.forEach((part, i) => {
      const shape = shapeObject(part, i, color, meshes);
      if (shape) group.add(shape);
    });
  }
  if (options.surfaces) {
    object.surfaces.forEach((surface, i) => group.add(surfaceObject(surface, i, color, meshes, options)));
  }
  if (options.handles !== "none") {
    object.handles.forEach((handle, i) => group.add(handleObject(handle, i, color, meshes, options)));
  }
  return group;
}
