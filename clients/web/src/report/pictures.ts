// The four pictures of the paper's table I, as scenes of the same objects.
import { Group, Object3D, Points, Scene } from "three";
import type { MeshSource } from "../scene/shape_geometry";
import { pointMaterial } from "../scene/materials";
import { objectModel, type ModelOptions } from "../scene/object_model";
import { matrixOf } from "../scene/pose";
import { runGeometries, type RunGeometry } from "./points";
import type { PointRun, ScanRecord } from "./record";
import { isExplainedByShape, ownerOf, type ScanObject } from "./scan_objects";

export interface Picture {
  name: string;
  title: string;
  caption: string;
  scene: Scene;
}

// The data that every picture is made from.
export interface Material {
  record: ScanRecord;
  scanObjects: readonly ScanObject[];
  meshes: MeshSource;
  pointSize_px: number;
}

// The colour of unassigned points, and of points that are only a background.
export const neutralColor = "#8a8f98";

type PointStyle = "own" | "neutral" | "none";

interface Recipe {
  name: string;
  title: string;
  caption: string;
  model: ModelOptions;
  points: (run: PointRun, scanObject: ScanObject | undefined) => PointStyle;
}

const hasMesh = (scanObject: ScanObject | undefined): boolean =>
  scanObject !== undefined && scanObject.object.surfaces.length > 0;

const recipes: readonly Recipe[] = [
  {
    name: "segmentation", title: "Segmentation", caption: "supports and object clusters",
    model: { shapes: false, surfaces: false, triangulation: false, handles: "none" },
    points: (_, scanObject) => (scanObject ? "own" : "neutral"),
  },
  {
    name: "shapes", title: "Shapes", caption: "fitted primitives; points that none explains",
    model: { shapes: true, surfaces: false, triangulation: false, handles: "bounds" },
    points: (run, scanObject) => (isExplainedByShape(run, scanObject) ? "none" : "neutral"),
  },
  {
    name: "surfaces", title: "Surfaces", caption: "meshes of the rest; all other points",
    model: { shapes: false, surfaces: true, triangulation: true, handles: "mesh" },
    points: (run, scanObject) => (hasMesh(scanObject) && !isExplainedByShape(run, scanObject) ? "none" : "neutral"),
  },
  {
    name: "hybrid", title: "Hybrid model", caption: "shapes and surfaces together",
    model: { shapes: true, surfaces: true, triangulation: false, handles: "mesh" },
    points: () => "none",
  },
];

// A child of the scene for each object (userData.objectIndex, -1 for unassigned points), so that one can
// be highlighted.
function build(recipe: Recipe, material: Material, runs: readonly RunGeometry[]): Picture {
  const scene = new Scene();
  const X_WC = matrixOf(material.record.response.x_world_sensor);
  const groups = new Map<number, Group>();
  const groupOf = (index: number): Group => {
    let group = groups.get(index);
    if (group === undefined) {
      group = new Group();
      group.userData["objectIndex"] = index;
      groups.set(index, group);
      scene.add(group);
    }
    return group;
  };
  for (const { run, geometry } of runs) {
    const scanObject = ownerOf(run, material.record, material.scanObjects);
    const style = recipe.points(run, scanObject);
    if (style === "none") continue;
    const color = style === "own" && scanObject ? scanObject.color : neutralColor;
    const points = new Points(geometry, pointMaterial(color, material.pointSize_px));
    points.matrixAutoUpdate = false;
    points.matrix.copy(X_WC);
    points.userData["run"] = run;
    groupOf(scanObject?.index ?? -1).add(points);
  }
  for (const scanObject of material.scanObjects) {
    const model: Object3D = objectModel(scanObject.object, scanObject.color, material.meshes, recipe.model);
    if (model.children.length > 0) groupOf(scanObject.index).add(model);
  }
  return { name: recipe.name, title: recipe.title, caption: recipe.caption, scene };
}

export function buildPictures(material: Material): Picture[] {
  const runs = runGeometries(material.record.points);
  return recipes.map((recipe) => build(recipe, material, runs));
}
