// The extent of an object by its drawn geometry, since a scan's reply has no bounds.
import { Box3, Matrix4, Vector3, type BufferGeometry } from "three";
import type { WorldObject } from "../world/types";
import { matrixOf } from "./pose";
import { boxGeometry, shapeGeometry, type MeshSource } from "./shape_geometry";

function add(geometry: BufferGeometry, X_FG: Matrix4, bounds: Box3): void {
  const position = geometry.getAttribute("position");
  const vertex = new Vector3();
  for (let i = 0; i < position.count; ++i) {
    bounds.expandByPoint(vertex.fromBufferAttribute(position, i).applyMatrix4(X_FG));
  }
}

// Bounds along the axes of frame F, with the object's frame at X_FO. Empty for an object without
// parts; half-spaces are unbounded and do not count.
export function objectBounds(object: WorldObject, meshes: MeshSource, X_FO: Matrix4): Box3 {
  const bounds = new Box3();
  for (const part of object.shapes) {
    const geometry = part.half_space ? undefined : shapeGeometry(part, meshes);
    if (geometry) add(geometry, X_FO.clone().multiply(matrixOf(part.x_object_shape)), bounds);
  }
  for (const surface of object.surfaces) add(meshes(surface.hash), X_FO, bounds);
  for (const { bounds: box } of object.handles) {
    add(boxGeometry(box.box), X_FO.clone().multiply(matrixOf(box.x_object_box)), bounds);
  }
  return bounds;
}
