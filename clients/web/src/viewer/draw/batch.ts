// Instances drawn in one call, which can be added, moved and removed. A slot is the handle of an
// instance.
import type { Color, Matrix4, Object3D, Raycaster } from "three";

export interface Slot<Owner> { readonly owner: Owner; index: number; }

export interface Hit<Owner> { owner: Owner; distance: number; }

export interface Batch<Owner> {
  readonly object: Object3D;
  readonly count: number;
  setMatrix(slot: Slot<Owner>, matrix: Matrix4): void;
  setColor(slot: Slot<Owner>, color: Color): void;
  remove(slot: Slot<Owner>): void;
  hits(raycaster: Raycaster): Hit<Owner>[];
}
