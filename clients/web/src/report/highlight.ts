// The highlighted object: the one under the pointer, otherwise the picked one.
export class Highlight {
  private hovered: number | undefined;
  private picked: number | undefined;
  private readonly listeners: (() => void)[] = [];

  get active(): number | undefined { return this.hovered ?? this.picked; }
  get pinned(): number | undefined { return this.picked; }

  onChange(listener: () => void): void { this.listeners.push(listener); }

  hover(thing: number | undefined): void {
    if (thing === this.hovered) return;
    this.hovered = thing;
    this.tell();
  }

  // Picking the picked object again deselects it.
  pick(thing: number | undefined): void {
    this.picked = thing === this.picked ? undefined : thing;
    this.tell();
  }

  private tell(): void { for (const listener of this.listeners) listener(); }
}
