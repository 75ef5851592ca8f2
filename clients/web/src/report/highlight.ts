// The highlighted object: the one under the pointer, otherwise the picked one.
export class Highlight {
  private hovered: number | undefined;
  private picked: number | undefined;
  private readonly listeners: (() => void)[] = [];

  get active(): number | undefined { return this.hovered ?? this.picked; }
  get pinned(): number | undefined { return this.picked; }

  onChange(listener: () => void): void { this.listeners.push(listener); }

  hover(index: number | undefined): void {
    if (index === this.hovered) return;
    this.hovered = index;
    this.tell();
  }

  // Picking the picked object again deselects it.
  pick(index: number | undefined): void {
    this.picked = index === this.picked ? undefined : index;
    this.tell();
  }

  private tell(): void { for (const listener of this.listeners) listener(); }
}
