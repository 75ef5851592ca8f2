// All objects by kind, with counts, search and visibility. Rows are buttons of a tree: one of them
// is a tab stop, the others are reached from it by arrow keys.
import { element, swatch } from "../../page/dom";
import { naturalOrder } from "../../page/natural_order";
import { count } from "../../page/quantity";
import { statusText, visibilityWord } from "../object_status";
import { isRobot, kinds, kindTitles, type Kind, type SceneObject } from "../scene_objects";

export interface TreeListener {
  select: (name: string) => void;
  frame: (name: string) => void;
  toggle: (name: string) => void;
  toggleKind: (kind: Kind) => void;
}

interface Row { root: HTMLElement; box: HTMLInputElement; name: HTMLElement; state: HTMLElement; sceneObject: SceneObject | undefined; }

interface Branch { root: HTMLElement; list: HTMLElement; box: HTMLInputElement; count: HTMLElement; title: HTMLElement; isOpen: boolean; }

// chosen: longer lists are searched rather than read, and would cost more than the picture.
const maxRows = 400;

// Movers have no identity: their names change their holders from frame to frame, so they are only
// counted.
const isListed = ({ kind }: SceneObject): boolean => kind !== "mover";

function countListed(sceneObjects: ReadonlyMap<string, SceneObject>): number {
  let listed = 0;
  for (const sceneObject of sceneObjects.values()) if (isListed(sceneObject)) ++listed;
  return listed;
}

function checkbox(label: string): HTMLInputElement {
  const box = element("input");
  box.type = "checkbox";
  box.checked = true;
  box.tabIndex = -1;
  box.setAttribute("aria-label", label);
  return box;
}

export class Tree {
  readonly root = element("section", "tree");
  readonly search = element("input", "search");
  private readonly list = element("div", "branches");
  private readonly rows = new Map<string, Row>();
  private readonly branches = new Map<Kind, Branch>();
  private sceneObjects: ReadonlyMap<string, SceneObject> = new Map();
  private stop: HTMLElement | undefined;  // the tab stop
  private selected: string | undefined;
  private hidden: { names: ReadonlySet<string>; kinds: ReadonlySet<Kind> } = { names: new Set(), kinds: new Set() };

  constructor(private readonly listener: TreeListener) {
    this.search.type = "search";
    this.search.placeholder = "Search  /";
    this.search.setAttribute("aria-label", "Search objects by name");
    this.search.addEventListener("input", () => this.build());
    this.search.addEventListener("keydown", (event) => this.onSearchKey(event));
    this.list.setAttribute("role", "tree");
    this.list.setAttribute("aria-label", "Objects by kind");
    this.list.addEventListener("keydown", (event) => this.onKey(event));
    this.list.addEventListener("focusin", ({ target }) => {
      if (target instanceof HTMLButtonElement) this.stopAt(target);
    });
    for (const kind of kinds) this.branches.set(kind, this.branch(kind));
    this.list.append(...[...this.branches.values()].map(({ root }) => root));
    this.root.append(this.search, this.list);
  }

  // Most changes only move objects: rows are rebuilt only if objects were added, removed or look
  // different.
  show(sceneObjects: ReadonlyMap<string, SceneObject>): void {
    const before = this.sceneObjects;
    this.sceneObjects = new Map(sceneObjects);
    let isSame = countListed(before) === countListed(sceneObjects);
    for (const [name, sceneObject] of sceneObjects) {
      if (!isListed(sceneObject)) continue;
      const was = before.get(name);
      isSame &&= was !== undefined && was.kind === sceneObject.kind && was.color === sceneObject.color;
      if (!isSame) break;
    }
    if (!isSame) this.build();
    else for (const [name, row] of this.rows) this.refresh(row, sceneObjects.get(name));
    this.countMovers();
  }

  private countMovers(): void {
    const branch = this.branches.get("mover");
    if (!branch) return;
    const movers = this.sceneObjects.size - countListed(this.sceneObjects);
    branch.root.hidden = movers === 0;
    branch.count.textContent = count(movers);
  }

  setHidden(names: ReadonlySet<string>, hiddenKinds: ReadonlySet<Kind>): void {
    this.hidden = { names, kinds: hiddenKinds };
    for (const [name, row] of this.rows) {
      row.box.checked = !names.has(name);
      row.root.classList.toggle("off", names.has(name));
    }
    for (const [kind, branch] of this.branches) {
      branch.box.checked = !hiddenKinds.has(kind);
      branch.root.classList.toggle("off", hiddenKinds.has(kind));
    }
  }

  select(name: string | undefined): void {
    const before = this.selected === undefined ? undefined : this.rows.get(this.selected);
    before?.name.setAttribute("aria-selected", "false");
    before?.root.classList.remove("selected");
    this.selected = name;
    const row = name === undefined ? undefined : this.rows.get(name);
    row?.name.setAttribute("aria-selected", "true");
    row?.root.classList.add("selected");
    if (row && !this.list.contains(document.activeElement) && this.buttons().includes(row.name)) this.stopAt(row.name);
    row?.root.scrollIntoView({ block: "nearest" });
  }

  private branch(kind: Kind): Branch {
    const root = element("div", "branch");
    const title = element("button", "kind", kindTitles[kind]);
    title.type = "button";
    const number = element("span", "count");
    title.append(number);
    title.tabIndex = -1;
    title.setAttribute("role", "treeitem");
    title.setAttribute("aria-expanded", "true");
    const box = checkbox(`Show ${kindTitles[kind]}`);
    box.addEventListener("change", () => this.listener.toggleKind(kind));
    const list = element("div", "leaves");
    list.setAttribute("role", "group");
    const head = element("div", "row head", box, title);
    head.setAttribute("role", "none");
    root.setAttribute("role", "none");
    root.append(head, list);
    const branch: Branch = { root, list, box, count: number, title, isOpen: true };
    title.addEventListener("click", () => this.open(branch, !branch.isOpen));
    return branch;
  }

  private open(branch: Branch, isOpen: boolean): void {
    branch.isOpen = isOpen;
    branch.list.hidden = !isOpen;
    branch.title.setAttribute("aria-expanded", String(isOpen));
    if (!isOpen && this.stop && branch.list.contains(this.stop)) this.stopAt(branch.title);
  }

  private build(): void {
    const wanted = this.search.value.trim().toLowerCase();
    const focused = document.activeElement instanceof HTMLElement ? document.activeElement.dataset["thing"] : undefined;
    const stop = this.stop?.dataset["thing"];
    const sorted = [...this.sceneObjects.values()].filter(isListed).sort((a, b) => naturalOrder.compare(a.name, b.name));
    this.rows.clear();
    for (const [kind, branch] of this.branches) {
      const all = sorted.filter((sceneObject) => sceneObject.kind === kind);
      const found = wanted === "" ? all : all.filter(({ name }) => name.toLowerCase().includes(wanted));
      branch.root.hidden = found.length === 0;
      branch.count.textContent = found.length === all.length ? count(all.length) : `${count(found.length)} of ${count(all.length)}`;
      branch.list.replaceChildren(...found.slice(0, maxRows).map((sceneObject) => this.row(sceneObject)));
      if (found.length > maxRows) branch.list.append(element("p", "more", `and ${count(found.length - maxRows)} more: search for them`));
    }
    this.countMovers();
    this.setHidden(this.hidden.names, this.hidden.kinds);
    this.select(this.selected);
    const kept = stop === undefined ? this.stop : this.rows.get(stop)?.name;
    const all = this.buttons();
    this.stopAt(kept && all.includes(kept) ? kept : all[0]);
    // If the focused row was removed, the focus moves to the tab stop.
    if (focused !== undefined) (this.rows.get(focused)?.name ?? this.stop)?.focus();
  }

  // Makes the button the tab stop.
  private stopAt(button: HTMLElement | undefined): void {
    if (this.stop) this.stop.tabIndex = -1;
    this.stop = button;
    if (button) button.tabIndex = 0;
  }

  private row(sceneObject: SceneObject): HTMLElement {
    const { name } = sceneObject;
    const box = checkbox(`Show ${name}`);
    box.addEventListener("change", () => this.listener.toggle(name));
    const button = element("button", "name", swatch(sceneObject.color), element("span", "text", name));
    button.type = "button";
    button.tabIndex = -1;
    button.setAttribute("role", "treeitem");
    button.setAttribute("aria-selected", "false");
    button.dataset["thing"] = name;
    button.addEventListener("click", () => this.listener.select(name));
    button.addEventListener("dblclick", () => this.listener.frame(name));
    const state = element("span", "state");
    const root = element("div", "row leaf", box, button, state);
    root.setAttribute("role", "none");
    const row: Row = { root, box, name: button, state, sceneObject: undefined };
    this.rows.set(name, row);
    this.refresh(row, sceneObject);
    return root;
  }

  private refresh(row: Row, sceneObject: SceneObject | undefined): void {
    if (!sceneObject || row.sceneObject === sceneObject) return;
    row.sceneObject = sceneObject;
    const { source } = sceneObject;
    const status = isRobot(source) ? "" : statusText(source);
    if (row.state.textContent === status) return;
    row.state.textContent = status;
    row.state.classList.toggle("seen", !isRobot(source) && visibilityWord(source) === "visible");
  }

  // The rows that are visible while the list is, from the top.
  private buttons(): HTMLElement[] {
    return [...this.branches.values()].filter(({ root }) => !root.hidden).flatMap(({ title, list, isOpen }) =>
      [title, ...(isOpen ? list.querySelectorAll<HTMLElement>(".name") : [])]);
  }

  private onKey(event: KeyboardEvent): void {
    const all = this.buttons();
    const at = all.indexOf(document.activeElement as HTMLElement);
    const name = all[at]?.dataset["thing"];
    const branch = [...this.branches.values()].find(({ title }) => title === all[at]);
    if (event.key === "ArrowDown") all[Math.min(at + 1, all.length - 1)]?.focus();
    else if (event.key === "ArrowUp" && at > 0) all[at - 1]?.focus();
    else if (event.key === "Home") all[0]?.focus();
    else if (event.key === "End") all.at(-1)?.focus();
    else if (event.key === "ArrowLeft") this.leave(name, branch);
    else if (event.key === "ArrowRight" && branch) this.open(branch, true);
    else if (event.key === " ") this.toggleFocused(name, branch);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  private leave(name: string | undefined, branch: Branch | undefined): void {
    if (branch) this.open(branch, false);
    const kind = name === undefined ? undefined : this.rows.get(name)?.sceneObject?.kind;
    if (kind) this.branches.get(kind)?.title.focus();
  }

  private toggleFocused(name: string | undefined, branch: Branch | undefined): void {
    const kind = [...this.branches].find(([, one]) => one === branch)?.[0];
    if (name !== undefined) this.listener.toggle(name);
    else if (kind) this.listener.toggleKind(kind);
  }

  private onSearchKey(event: KeyboardEvent): void {
    const leaves = this.buttons().filter((button) => button.dataset["thing"] !== undefined);
    if (event.key === "ArrowDown") leaves[0]?.focus();
    else if (event.key === "Enter" && leaves[0]?.dataset["thing"] !== undefined) this.listener.select(leaves[0].dataset["thing"]);
    else if (event.key === "Escape" && this.search.value !== "") {
      this.search.value = "";
      this.build();
      event.stopPropagation();
    } else return;
    event.preventDefault();
  }
}
