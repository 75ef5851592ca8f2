// The supports, objects and residuals of the scan in one list, each with its colour.
import { Box3, Matrix4, Vector3 } from "three";
import type { MeshSource } from "../scene/shape_geometry";
import { objectBounds } from "../scene/object_bounds";
import { colorsOfPlaces, repeated, residualColors, supportColors } from "../scene/palette";
import { matrixOf } from "../scene/pose";
import { shortName, type WorldObject } from "../world/types";
import type { PointRun, ScanRecord } from "./record";

export interface ScanObject {
  index: number;  // in the list
  object: WorldObject;
  kind: string;   // "support", "object", "residual"
  color: string;
  bounds: Box3;   // in the world
  size: Vector3;  // in the object's frame, m
}

// In the order of the response, so that a run's owner is found by index.
export function scanObjectsOf(record: ScanRecord, meshes: MeshSource): ScanObject[] {
  const all = [...record.response.supports, ...record.response.objects];
  const scanObjects = all.map((object, index): ScanObject => ({
    index, object, kind: shortName(object.kind, "OBJECT_KIND"), color: residualColors[0] as string,
    bounds: objectBounds(object, meshes, matrixOf(object.x_world_object)),
    size: objectBounds(object, meshes, new Matrix4()).getSize(new Vector3()),
  }));
  const objects = scanObjects.filter((scanObject) => scanObject.kind === "object");
  const places = objects.map((scanObject) => scanObject.bounds.getCenter(new Vector3()));
  colorsOfPlaces(places).forEach((color, i) => { (objects[i] as ScanObject).color = color; });
  for (const [kind, colors] of [["support", supportColors], ["residual", residualColors]] as const) {
    scanObjects.filter((scanObject) => scanObject.kind === kind)
      .forEach((scanObject, i) => { scanObject.color = repeated(colors, i); });
  }
  return scanObjects;
}

// The object that a run's points belong to; undefined if they are unassigned.
export function ownerOf(run: PointRun, record: ScanRecord, scanObjects: readonly ScanObject[]): ScanObject | undefined {
  if (run.owner === "nobody") return undefined;
  return scanObjects[run.owner === "support" ? run.index : record.response.supports.length + run.index];
}

// True if a shape explains the run's points.
export function isExplainedByShape(run: PointRun, scanObject: ScanObject | undefined): boolean {
  if (scanObject === undefined) return false;
  if (run.owner === "support") return scanObject.object.shapes.length > 0;
  return run.part >= 1 && run.part <= scanObject.object.shapes.length;
}
