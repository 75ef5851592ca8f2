// The colours of objects. An object keeps its colour while it exists, whatever happens around it.
import { Vector3 } from "three";
import { objectColors, repeated, residualColors, supportColors } from "../scene/palette";
import { shortName, type WorldObject } from "../world/types";
import { nearerColor } from "./pixel_classes";

// Users' objects have a colour of their own, apart from all perceived ones.
export const unseenColor = "#8d86a8";
export const robotColors: readonly string[] = ["#c9ced6", "#b9c4cf", "#d2c8bb"];

// `index` is the index of an object's colour, or -1 for colours of other kinds.
interface Entry { color: string; index: number; place: Vector3; kind: string; }

export class ColorAssignment {
  private readonly entries = new Map<string, Entry>();
  private readonly counts = new Map<string, number>();

  // Updates the colours for the present objects and forgets the others.
  update(objects: Iterable<WorldObject>): void {
    const present = new Set<string>();
    for (const object of objects) {
      present.add(object.name);
      const kind = shortName(object.kind, "OBJECT_KIND");
      if (this.entries.get(object.name)?.kind !== kind) this.enter(object, kind);
    }
    for (const name of [...this.entries.keys()]) {
      if (!present.has(name)) this.entries.delete(name);
    }
  }

  of(name: string): string { return this.entries.get(name)?.color ?? (residualColors[0] as string); }

  private enter(object: WorldObject, kind: string): void {
    const pose = object.x_world_object;
    const place = new Vector3(pose?.tx_m ?? 0, pose?.ty_m ?? 0, pose?.tz_m ?? 0);
    // A half-space is a floor or a wall, and fills the picture.
    const looksLike = object.shapes.some(({ half_space }) => half_space) ? "support" : kind;
    const color = this.choose(looksLike, place);
    this.entries.set(object.name, { color, index: objectColors.indexOf(color), place, kind });
  }

  private choose(kind: string, place: Vector3): string {
    if (kind === "unseen") return unseenColor;
    if (kind === "mover") return nearerColor;
    if (kind === "support") return repeated(supportColors, this.next(kind));
    if (kind === "residual") return repeated(residualColors, this.next(kind));
    return this.farthest(place);
  }

  private next(kind: string): number {
    const count = this.counts.get(kind) ?? 0;
    this.counts.set(kind, count + 1);
    return count;
  }

  // The colour whose nearest holder is farthest away, with ties resolved by order. Computed on
  // plain numbers, since thousands of objects are compared with thousands before the first picture.
  private farthest({ x, y, z }: Vector3): string {
    const nearest = new Float64Array(objectColors.length).fill(Infinity);
    for (const { index, place } of this.entries.values()) {
      if (index < 0) continue;
      const squared = (place.x - x) ** 2 + (place.y - y) ** 2 + (place.z - z) ** 2;
      if (squared < (nearest[index] as number)) nearest[index] = squared;
    }
    return objectColors[nearest.indexOf(Math.max(...nearest))] as string;
  }
}
