// Draws grippers at their grasps: all boxes in one draw call, the approaches, and the outline of
// the chosen one.
import { Box3, Color, Group, Matrix4, Vector3, type Raycaster } from "three";
import { matrixOf } from "../../scene/pose";
import { scoreColor, type Grasp, type GripperBox } from "../grasps";
import type { Hit, Slot } from "./batch";
import { arrowSegments, boxSegments, Lines, type Segment } from "./lines";
import { ShapeBatch } from "./shape_batch";

const lineWidth_px = 2;
const staleColor = "#8a8f96";
const normalLength_m = 0.04;

export interface DrawnGrasp { grasp: Grasp; isStale: boolean; }

export interface GraspPicture {
  boxes: readonly GripperBox[];
  shown: readonly DrawnGrasp[];
  chosen: Grasp | undefined;
}

export const noGrasps: GraspPicture = { boxes: [], shown: [], chosen: undefined };

const vector = ([x, y, z]: readonly [number, number, number]): Vector3 => new Vector3(x, y, z);

const colorOf = ({ grasp, isStale }: DrawnGrasp): string => (isStale ? staleColor : scoreColor(grasp.score));

const placeOf = ({ tx_m, ty_m, tz_m }: Grasp["x_world_grasp"]): Vector3 => new Vector3(tx_m, ty_m, tz_m);

function outline(boxes: readonly GripperBox[], { x_world_grasp }: Grasp, color: string): Segment[] {
  const X = matrixOf(x_world_grasp);
  return boxes.flatMap(({ centre, size_m }) =>
    boxSegments(new Box3().setFromCenterAndSize(vector(centre), vector(size_m)), X, color));
}

// The path from the gripper's start to between its pads.
function approach({ x_world_grasp, x_world_pregrasp }: Grasp, color: string): Segment[] {
  const [from, to] = [placeOf(x_world_pregrasp), placeOf(x_world_grasp)];
  const way = to.clone().sub(from);
  return way.lengthSq() === 0 ? [] : arrowSegments(from, way, way.length(), color);
}

export class GraspView {
  readonly root = new Group();
  private batch: ShapeBatch<Grasp> | undefined;  // made with the first gripper, since most pages do
                                                 // not need its programs
  private slots: Slot<Grasp>[] = [];
  private readonly ways = new Lines(lineWidth_px, false);
  private readonly chosen = new Lines(1.5 * lineWidth_px, true);
  private count_ = 0;

  constructor() {
    this.root.add(this.ways.object, this.chosen.object);
  }

  // The number of drawn grippers.
  get count(): number { return this.count_; }

  set({ boxes, shown, chosen }: GraspPicture, accent: string): void {
    for (const slot of this.slots.reverse()) this.batch?.remove(slot);
    this.slots = [];
    if (shown.length > 0) this.batch ??= this.makeBatch();
    if (this.batch) {
      for (const drawn of shown) this.add(this.batch, boxes, drawn);
      this.batch.object.visible = shown.length > 0;
    }
    this.count_ = shown.length;
    this.ways.set(shown.filter(({ grasp }) => grasp !== chosen).flatMap((drawn) => approach(drawn.grasp, colorOf(drawn))));
    this.chosen.set(chosen && shown.some(({ grasp }) => grasp === chosen) ? this.marks(boxes, chosen, accent) : []);
  }

  hits(raycaster: Raycaster): Hit<Grasp> | undefined {
    return this.batch?.hits(raycaster).sort((a, b) => a.distance - b.distance)[0];
  }

  private makeBatch(): ShapeBatch<Grasp> {
    const batch = new ShapeBatch<Grasp>("box", "ghost", (before, now) => this.root.remove(before).add(now));
    batch.object.renderOrder = 4;
    this.root.add(batch.object);
    return batch;
  }

  private add(batch: ShapeBatch<Grasp>, boxes: readonly GripperBox[], drawn: DrawnGrasp): void {
    const X = matrixOf(drawn.grasp.x_world_grasp);
    const color = new Color(colorOf(drawn));
    for (const { centre, size_m } of boxes) {
      const local = new Matrix4().makeTranslation(...centre).scale(vector(size_m));
      this.slots.push(batch.add(drawn.grasp, new Matrix4().multiplyMatrices(X, local), color, [0, 0]));
    }
  }

  private marks(boxes: readonly GripperBox[], chosen: Grasp, accent: string): Segment[] {
    const normals = chosen.contacts.filter(({ normal }) => vector(normal).lengthSq() > 0)
      .flatMap(({ point, normal }) => arrowSegments(vector(point), vector(normal), normalLength_m, "#f59f00"));
    return [...outline(boxes, chosen, accent), ...approach(chosen, accent), ...normals];
  }
}
