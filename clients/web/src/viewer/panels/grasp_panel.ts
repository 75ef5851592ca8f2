// The grasps of a file, the best first, and whether they still hold; an entry is chosen by a click
// or a key.
import { element, swatch, withTitle } from "../../page/dom";
import { naturalOrder } from "../../page/natural_order";
import { fixed, mm, plural } from "../../page/quantity";
import { position } from "../../page/shape_text";
import { directionText, scoreColor, type Grasp, type GraspPlan } from "../grasps";

export interface GraspListener {
  choose: (grasp: Grasp) => void;
  showAll: (isOn: boolean) => void;
  close: () => void;
}

// chosen: the rows of a readable list; all grasps are drawn.
const maxRows = 300;

export class GraspPanel {
  readonly root = element("section", "grasps");
  private readonly body = element("div", "");
  private readonly opening = element("span", "opening");
  private readonly error = element("p", "error");
  private readonly warning = element("p", "warning");
  private readonly list = element("div", "ranking");
  private readonly rows = new Map<Grasp, { row: HTMLButtonElement; note: HTMLElement }>();

  constructor(private readonly listener: GraspListener) {
    const close = element("button", "quiet close", "\u2715");
    close.setAttribute("aria-label", "Put the grasps away");
    close.addEventListener("click", () => listener.close());
    this.root.setAttribute("aria-label", "Grasps");
    this.error.setAttribute("role", "alert");
    this.warning.setAttribute("role", "status");
    this.list.addEventListener("keydown", (event) => this.onKey(event));
    this.root.append(close, element("h2", "", "Grasps", this.opening), this.error, this.body);
    this.root.hidden = true;
    this.error.hidden = true;
  }

  // A file that cannot be read leaves the present grasps unchanged.
  showError(file: string, text: string): void {
    this.error.textContent = `${file}: ${text}`;
    this.error.hidden = false;
    this.root.hidden = false;
  }

  show(file: string, plan: GraspPlan, isAll: boolean): void {
    const { grasps, graspless, opening_m } = plan;
    this.error.hidden = true;
    this.root.hidden = false;
    this.rows.clear();
    this.list.replaceChildren(...grasps.slice(0, maxRows).map((grasp) => this.row(grasp)));
    if (grasps.length > maxRows) this.list.append(element("p", "more", `${grasps.length - maxRows} more, drawn but not listed`));
    this.opening.textContent = `opening ${mm(opening_m, 0)} mm`;
    const objects = new Set(grasps.map(({ object }) => object)).size;
    this.body.replaceChildren(
      withTitle(element("p", "of", `${plural(grasps.length, "grasp")} of ${plural(objects, "object")}`), file),
      this.warning, ...(grasps.length > 0 ? [this.legend(), this.choice(isAll), this.list] : []), ...this.without(graspless));
  }

  // Shows whether the plan and each of its grasps still hold.
  showStaleness(warning: string, of: (grasp: Grasp) => string): void {
    this.warning.textContent = warning;
    this.warning.hidden = warning === "";
    for (const [grasp, { row, note }] of this.rows) {
      const text = of(grasp);
      if (note.textContent !== text) note.textContent = text;
      row.classList.toggle("stale", text !== "");
    }
  }

  choose(grasp: Grasp | undefined): void {
    for (const [of, { row }] of this.rows) {
      row.setAttribute("aria-pressed", String(of === grasp));
      if (of === grasp) row.scrollIntoView({ block: "nearest" });
    }
  }

  clear(): void {
    this.rows.clear();
    this.body.replaceChildren();
    this.opening.textContent = "";
    this.error.hidden = true;
    this.root.hidden = true;
  }

  private row(grasp: Grasp): HTMLElement {
    const { rank, object, way, score, width_m, clearance_m, x_world_grasp } = grasp;
    const note = element("span", "note");
    const row = element("button", "grasp", element("span", "rank", String(rank)), swatch(scoreColor(score)),
      element("span", "text", object), note, element("span", "width", `${mm(width_m)} mm`), element("span", "score", fixed(score, 2)),
      element("span", "how", `${way} ${position(x_world_grasp).join(" ")}`), element("span", "how", directionText(grasp)));
    row.type = "button";
    row.title = `${way}, clearance ${mm(clearance_m)} mm`;
    row.setAttribute("aria-pressed", "false");
    row.addEventListener("click", () => this.listener.choose(grasp));
    this.rows.set(grasp, { row, note });
    return row;
  }

  private legend(): HTMLElement {
    const bar = element("span", "bar");
    [0, 1, 2, 3].forEach((stop) => bar.style.setProperty(`--stop-${stop}`, scoreColor(stop / 3)));
    return element("p", "quality", "quality 0", bar, "1", swatch("#8a8f96"), "stale");
  }

  private choice(isAll: boolean): HTMLElement {
    const box = element("input", "");
    box.type = "checkbox";
    box.checked = isAll;
    box.addEventListener("change", () => this.listener.showAll(box.checked));
    return withTitle(element("label", "all", box, "Draw all, not only the best"), "the best of each object");
  }

  private without(graspless: GraspPlan["graspless"]): HTMLElement[] {
    if (graspless.length === 0) return [];
    return [element("details", "", element("summary", "", `${plural(graspless.length, "object")} without a grasp`),
      ...[...graspless].sort((a, b) => naturalOrder.compare(a.object, b.object)).slice(0, maxRows).map(({ object, why }) => element("p", "why", element("b", "", object), ` ${why}`)))];
  }

  private onKey(event: KeyboardEvent): void {
    const step = event.key === "ArrowDown" ? "nextElementSibling" : event.key === "ArrowUp" ? "previousElementSibling" : undefined;
    const next = step && document.activeElement?.[step];
    if (!(next instanceof HTMLButtonElement)) return;
    next.focus();
    event.preventDefault();
    event.stopPropagation();
  }
}
