// The picture of a world: visible objects, the selection, names and frames, scans, and the result
// of a query.
import { Box3, Matrix4, Vector3 } from "three";
import type { Scan } from "../../world/stream";
import { matrixOf } from "../../scene/pose";
import type { QueryResult } from "../query_result";
import type { Query } from "../query";
import type { Grasp } from "../grasps";
import { frameOf, isRobot, type SceneObject } from "../scene_objects";
import type { RobotGhosts } from "../robot_ghosts";
import { bodiesOf, isBody, resultPicture, type ResultPicture } from "./result_view";
import { MeshLibrary } from "./blobs";
import { Clouds } from "./cloud";
import { GraspView, noGrasps, type GraspPicture } from "./grasp_view";
import type { Label } from "./labels";
import { LivePoints } from "./live_points";
import { boxSegments, frameSegments, Lines } from "./lines";
import { hiddenParts, type Layer } from "./parts";
import { Stage } from "./stage";
import { WorldView, type DrawnObject } from "./world_view";

const lineWidth_px = 2;
const axesLength_m = 0.2;

// The space into which the selected object may extend. No object has this name.
const hiddenName = "\u0000hidden";
const hiddenColor = "#8b5cf6";

// Meshes and robots are loaded after the objects they belong to.
const firstFraming_ms = 2500;

export interface Shown { names: boolean; frames: boolean; }

export class Picture {
  readonly stage = new Stage();
  readonly view: WorldView;
  readonly clouds: Clouds;
  readonly livePoints = new LivePoints();
  readonly grasps = new GraspView();
  shown: Shown = { names: false, frames: false };
  private sceneObjects: readonly SceneObject[] = [];
  private byName: ReadonlyMap<string, SceneObject> = new Map();
  private selected: SceneObject | undefined;
  private result: ResultPicture | undefined;
  private graspPicture: GraspPicture = noGrasps;
  private graspsAreStale = false;
  private isStale = false;
  private selectionColor = "#1f5fbf";
  private isFramed = false;
  private firstFramed_ms = 0;
  private readonly axes = new Lines(lineWidth_px, false);
  private readonly selection = new Lines(lineWidth_px, true);
  private readonly resultLines = new Lines(1.5 * lineWidth_px, true);

  constructor(colorOf: (name: string) => string | undefined, failed: (why: string) => void) {
    const changed = (): void => this.refresh();
    this.view = new WorldView(new MeshLibrary(failed), changed);
    this.clouds = new Clouds(colorOf, () => this.stage.requestRender(), failed);
    this.stage.scene.add(this.view.root, this.clouds.root, this.livePoints.root, this.grasps.root, this.axes.object, this.selection.object,
                         this.resultLines.object);
    this.stage.beforeFrame = () => this.update();
    this.stage.frame([new Box3(new Vector3(-0.5, -0.5, 0), new Vector3(0.5, 0.5, 0.5))], "1");
    this.stage.prepare();
  }

  // Sets the visible objects; the picture follows with its next frame.
  setObjects(sceneObjects: readonly SceneObject[]): void {
    this.sceneObjects = sceneObjects;
    this.byName = new Map(sceneObjects.map((sceneObject) => [sceneObject.name, sceneObject]));
    this.refresh();
  }

  setSelected(sceneObject: SceneObject | undefined): void {
    this.selected = sceneObject;
    this.refresh();
  }

  setScans(scans: readonly Scan[]): void { this.clouds.sync(scans); }

  setPendingQuery(query: Query): void {
    this.result = { bodies: bodiesOf(query, "asked", { objects: this.byName, ghosts: [] }), segments: [], labels: [] };
    this.refresh();
  }

  setResult(query: Query, result: QueryResult, ghosts: RobotGhosts): void {
    const size = this.stage.camera.position.distanceTo(this.stage.orbit.target);
    this.result = resultPicture(query, result, size / 18, {
      objects: this.byName, ghosts, boundsOf: (name) => this.finiteBounds(name),
      frameBounds: (drawn, frame) => this.view.frameBounds(drawn, frame) });
    this.refresh();
  }

  clearResult(): void {
    this.result = undefined;
    this.refresh();
  }

  setSelectionColor(color: string): void {
    this.selectionColor = color;
    this.graspsAreStale = true;
    this.refresh();
  }

  setGrasps(grasps: GraspPicture | undefined): void {
    this.graspPicture = grasps ?? noGrasps;
    this.graspsAreStale = true;
    this.stage.requestRender();
  }

  hideLayers(layers: ReadonlySet<Layer>): void {
    this.view.hideLayers(layers);
    this.refresh();
  }

  refresh(): void {
    this.isStale = true;
    this.stage.requestRender();
  }

  // Frames the objects in `names`, or all visible ones.
  frame(names: readonly string[] | undefined, view?: string): void {
    this.update();
    this.stage.isTouched = true;
    const all = names ?? this.sceneObjects.map((sceneObject) => sceneObject.name);
    this.stage.frame(all.map((name) => this.finiteBounds(name)), view);
  }

  // The name of an object or a gripper's grasp, whichever the ray hits first.
  pick(event: PointerEvent): string | Grasp | undefined {
    const ray = this.stage.rayAt(event);
    const sceneObject = this.view.pick(ray);
    const gripper = this.grasps.hits(ray);
    if (gripper && gripper.distance < (sceneObject?.distance ?? Infinity)) return gripper.owner;
    const name = sceneObject?.owner;
    return name === undefined || isBody(name) || name === hiddenName ? undefined : name;
  }

  // The bounds of half-spaces, which are unbounded, are those of their drawn slab.
  private finiteBounds(name: string): Box3 {
    const sceneObject = this.byName.get(name);
    if (sceneObject && !isRobot(sceneObject.source) && sceneObject.source.shapes.some(({ half_space }) => half_space)) return new Box3();
    return this.view.boundsOf(name);
  }

  private update(): void {
    if (this.graspsAreStale) this.grasps.set(this.graspPicture, this.selectionColor);
    this.graspsAreStale = false;
    if (!this.isStale) return;
    this.isStale = false;
    const drawn = new Map<string, DrawnObject>(this.sceneObjects.map((sceneObject) => [sceneObject.name, sceneObject.drawn]));
    for (const body of this.result?.bodies ?? []) drawn.set(body.name, body);
    const hidden = this.hiddenOfSelected();
    if (hidden) drawn.set(hiddenName, hidden);
    this.view.sync(drawn);
    this.place();
    this.updateLines();
    this.stage.labels.set([...(this.result?.labels ?? []), ...(this.shown.names ? this.names() : this.nameOfSelected())]);
  }

  // The first view shows everything, including objects that arrive a moment later, unless the user
  // has moved the camera; the floor is at the bottom of the world, whether the sensor is above or
  // below it.
  private place(): void {
    const isLate = performance.now() - this.firstFramed_ms > firstFraming_ms || this.stage.isTouched;
    if (this.isFramed && isLate) return;
    const boxes = this.sceneObjects.filter(({ kind }) => kind !== "unseen").map(({ name }) => this.finiteBounds(name))
      .filter((box) => !box.isEmpty());
    if (boxes.length === 0) return;
    if (!this.isFramed) this.firstFramed_ms = performance.now();
    this.isFramed = true;
    this.stage.floor_m = Math.min(0, ...boxes.map(({ min }) => min.z));
    this.stage.frame(boxes, "1");
    this.stage.orbit.keepHome();
  }

  // Called for another world, to frame it anew.
  reset(): void {
    this.isFramed = false;
    this.stage.isTouched = false;
  }

  private updateLines(): void {
    const size = this.shown.frames ? this.sceneObjects.flatMap((sceneObject) => {
      const extent = this.finiteBounds(sceneObject.name).getSize(new Vector3()).length();
      const length_m = Math.min(Math.max(0.35 * extent, 0.02), 0.3);
      const frames = isRobot(sceneObject.source) ? sceneObject.drawn.frames : [frameOf(sceneObject)];
      return frames.flatMap((X) => frameSegments(X, isRobot(sceneObject.source) ? 0.08 : length_m));
    }) : [];
    this.axes.set([...frameSegments(new Matrix4(), axesLength_m), ...size]);
    this.selection.set(this.selectionSegments());
    this.resultLines.set(this.result?.segments ?? []);
  }

  private hiddenOfSelected(): DrawnObject | undefined {
    const { selected } = this;
    if (!selected || isRobot(selected.source) || !this.byName.has(selected.name)) return undefined;
    const parts = hiddenParts(selected.source).map((part) => ({ frame: 0, part }));
    if (parts.length === 0) return undefined;
    return { name: hiddenName, color: hiddenColor, shape: `${selected.drawn.shape} hidden`, frames: [frameOf(selected)], parts };
  }

  // The box around the selection, and around the space into which its parts may extend.
  private selectionSegments(): ReturnType<typeof boxSegments> {
    const sceneObject = this.selected;
    if (!sceneObject) return [];
    const drawn = this.hiddenOfSelected();
    const hidden = (drawn?.parts ?? []).flatMap(({ part }) =>
      boxSegments(new Box3(new Vector3(-0.5, -0.5, -0.5), new Vector3(0.5, 0.5, 0.5)),
                  frameOf(sceneObject).clone().multiply(part.local), hiddenColor));
    return [...hidden, ...this.boundsSegments(sceneObject)];
  }

  private boundsSegments(sceneObject: SceneObject): ReturnType<typeof boxSegments> {
    if (isRobot(sceneObject.source)) return boxSegments(this.view.boundsOf(sceneObject.name), new Matrix4(), this.selectionColor);
    const { bounds } = sceneObject.source;
    if (!bounds) return [];
    const { size_x_m: x, size_y_m: y, size_z_m: z } = bounds.box;
    const half = new Vector3(x, y, z).divideScalar(2).addScalar(0.002);  // beside the surface, not in it
    const X = frameOf(sceneObject).clone().multiply(matrixOf(bounds.x_object_box));
    return boxSegments(new Box3(half.clone().negate(), half), X, this.selectionColor);
  }

  private labelOf(sceneObject: SceneObject): Label[] {
    const bounds = this.finiteBounds(sceneObject.name);
    if (bounds.isEmpty()) return [];
    const at = bounds.getCenter(new Vector3()).setZ(bounds.max.z);
    return [{ text: sceneObject.name, at, kind: "name" }];
  }

  // Movers have no identity.
  private names(): Label[] {
    return this.sceneObjects.filter(({ kind }) => kind !== "unseen" && kind !== "mover").flatMap((sceneObject) => this.labelOf(sceneObject));
  }

  private nameOfSelected(): Label[] { return this.selected ? this.labelOf(this.selected) : []; }
}
