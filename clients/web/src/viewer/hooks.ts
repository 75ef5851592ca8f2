// The facts about the drawn page for tests: window.cwmViewer, read-only.
import { Vector3 } from "three";
import type { Stage } from "./draw/stage";
import type { SceneObject } from "./scene_objects";
import type { WorldView } from "./draw/world_view";

export interface Hooked {
  stage: Stage;
  view: WorldView;
  sceneObjects: () => Iterable<SceneObject>;
  isShown: (sceneObject: SceneObject) => boolean;
  facts: () => Record<string, unknown>;
}

export function publish({ stage, view, sceneObjects, isShown, facts }: Hooked): void {
  const objects = (): object[] => [...sceneObjects()].map((sceneObject) => {
    const bounds = view.boundsOf(sceneObject.name);
    const center = bounds.getCenter(new Vector3());
    const { x, y, isSeen } = stage.onScreen(center);
    return { name: sceneObject.name, kind: sceneObject.kind, color: sceneObject.color, is_shown: isShown(sceneObject), is_drawn: !bounds.isEmpty(),
             low: bounds.min.toArray(), high: bounds.max.toArray(), x, y, is_seen: isSeen };
  });
  const viewer = Object.freeze({
    objects,
    facts: (): object => ({ ...facts(), ...stage.figures, is_draft: stage.isDraft, script_times_ms: [...stage.scriptTimes_ms],
                            instances: view.instanceCount, grid_cell_m: stage.grid.cell_m }),
    project: (x: number, y: number, z: number): object => stage.onScreen(new Vector3(x, y, z)),
    // Draws once more, as if something had changed.
    draw: (): void => stage.requestRender(),
  });
  Object.defineProperty(window, "cwmViewer", { value: viewer, writable: false });
}
