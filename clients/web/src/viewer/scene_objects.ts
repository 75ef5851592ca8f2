// The objects and robots of a state in one list, each with its kind and its colour. Unchanged ones
// keep their identity, so that the picture updates only changed ones.
import { Matrix4, Vector3 } from "three";
import type { DrawnObject } from "./draw/world_view";
import { partsOf, shapeParts } from "./draw/parts";
import { matrixOf } from "../scene/pose";
import { shortName, type WorldObject } from "../world/types";
import { ColorAssignment, robotColors } from "./color_assignment";
import type { RobotModel } from "./feed";
import { dimmed, isDimmed, isStriped } from "./object_status";
import type { WorldState } from "./world_model";

export type Kind = "support" | "object" | "residual" | "user" | "unseen" | "mover" | "robot";

export const kinds: readonly Kind[] = ["object", "user", "support", "residual", "mover", "unseen", "robot"];

export const kindTitles: Record<Kind, string> = {
  object: "Objects", user: "User's objects", support: "Supports", residual: "Residuals", mover: "Movers", unseen: "Unseen space",
  robot: "Robots" };

export interface SceneObject {
  name: string;
  kind: Kind;
  color: string;
  source: WorldObject | RobotModel;
  drawn: DrawnObject;
}

export const isRobot = (source: SceneObject["source"]): source is RobotModel => "links" in source;

// Uids and revisions restart in a new world.
function sceneObjectOf(world_uid: string, object: WorldObject, color: string, before: SceneObject | undefined): SceneObject {
  const shape = `${world_uid} ${object.uid} ${object.geometry_revision} ${object.kind} ${isStriped(object)}`;
  const drawn: DrawnObject = {
    name: object.name, color: isDimmed(object) ? dimmed(color) : color, shape, frames: [matrixOf(object.x_world_object)],
    parts: before && before.drawn.shape === shape ? before.drawn.parts
      : partsOf(object).map((part) => ({ frame: 0, part })) };
  return { name: object.name, kind: shortName(object.kind, "OBJECT_KIND") as Kind, color, source: object, drawn };
}

function sceneRobotOf(world_uid: string, model: RobotModel, color: string, before: SceneObject | undefined): SceneObject {
  const { robot, links } = model;
  const shape = `${world_uid} robot ${robot.uid}`;
  const drawn: DrawnObject = {
    name: robot.name, color, shape, frames: links.map(({ x_world_link }) => matrixOf(x_world_link)),
    parts: before && before.drawn.shape === shape ? before.drawn.parts
      : links.flatMap(({ shapes }, frame) => shapes.flatMap((part) =>
        shapeParts(part, "shapes", "solid").map((one) => ({ frame, part: one })))) };
  return { name: robot.name, kind: "robot", color, source: model, drawn };
}

export class SceneObjectList {
  readonly byName = new Map<string, SceneObject>();
  private readonly colors = new ColorAssignment();

  update(state: WorldState, robots: ReadonlyMap<string, RobotModel>): void {
    this.colors.update(state.objects.values());
    for (const name of [...this.byName.keys()]) {
      if (!state.objects.has(name) && !robots.has(name)) this.byName.delete(name);
    }
    for (const object of state.objects.values()) {
      const { name } = object;
      const before = this.byName.get(name);
      if (before?.source !== object) this.byName.set(name, sceneObjectOf(state.world_uid, object, this.colors.of(name), before));
    }
    let index = 0;
    for (const model of robots.values()) {
      const color = robotColors[index++ % robotColors.length] as string;
      const before = this.byName.get(model.robot.name);
      if (before?.source !== model) this.byName.set(model.robot.name, sceneRobotOf(state.world_uid, model, color, before));
    }
  }
}

// The middle of an object's bounding box in the world, its origin if it has none: where the command
// line, too, has a named place.
export function centreOf(sceneObject: SceneObject | undefined): Vector3 | undefined {
  if (!sceneObject || isRobot(sceneObject.source)) return undefined;
  const { x_world_object, bounds } = sceneObject.source;
  return new Vector3().setFromMatrixPosition(matrixOf(bounds?.x_object_box)).applyMatrix4(matrixOf(x_world_object));
}

// The frame of an object; for a robot, that of its root link.
export const frameOf = ({ drawn }: SceneObject): Matrix4 => drawn.frames[0] ?? new Matrix4();
