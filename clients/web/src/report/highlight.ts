// Which thing is looked at: the one under the pointer, else the one that was picked.
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

  // Picking what is picked already lets it go.
  pick(thing: number | undefined): void {
    this.picked = thing === this.picked ? undefined : thing;
    this.tell();
  }

  private tell(): void { for (const listener of this.listeners) listener(); }
}
