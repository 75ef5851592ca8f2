// The facts about the drawn page for tests: window.cwmViewer, read-only.
import { Vector3 } from "three";
import type { Stage } from "./draw/stage";
import type { Thing } from "./things";
import type { WorldView } from "./draw/world_view";

export interface Hooked {
  stage: Stage;
  view: WorldView;
  things: () => Iterable<Thing>;
  isShown: (thing: Thing) => boolean;
  facts: () => Record<string, unknown>;
}

export function publish({ stage, view, things, isShown, facts }: Hooked): void {
  const objects = (): object[] => [...things()].map((thing) => {
    const bounds = view.boundsOf(thing.name);
    const center = bounds.getCenter(new Vector3());
    const { x, y, isSeen } = stage.onScreen(center);
    return { name: thing.name, kind: thing.kind, color: thing.color, is_shown: isShown(thing), is_drawn: !bounds.isEmpty(),
             low: bounds.min.toArray(), high: bounds.max.toArray(), x, y, is_seen: isSeen };
  });
  const viewer = Object.freeze({
    objects,
    facts: (): object => ({ ...facts(), ...stage.figures, script_times_ms: [...stage.scriptTimes_ms],
                            instances: view.instanceCount, grid_cell_m: stage.grid.cell_m }),
    project: (x: number, y: number, z: number): object => stage.onScreen(new Vector3(x, y, z)),
    // Draws once more, as if something had changed.
    draw: (): void => stage.requestRender(),
  });
  Object.defineProperty(window, "cwmViewer", { value: viewer, writable: false });
}
