// A line for typing a query, and its result as a table.
import { element } from "../../page/dom";
import type { QueryResult } from "../query_result";
import type { CallError } from "../messages";
import { examples, parseQuery, QueryError, type Query, type QueryWorld } from "../query";

export interface QueryListener {
  evaluate: (query: Query) => void;
  clear: () => void;
  select: (name: string) => void;
}

const maxKept = 50;

export class QueryPanel {
  readonly root = element("section", "question");
  readonly input = element("input", "line");
  readonly result = element("div", "answer");
  private readonly past: string[] = [];
  private at = 0;

  constructor(private readonly world: QueryWorld, private readonly listener: QueryListener) {
    this.root.setAttribute("aria-label", "Questions to the world");
    this.input.type = "text";
    this.input.spellcheck = false;
    this.input.autocomplete = "off";
    this.input.placeholder = `Ask:  ${examples[0] ?? ""}`;
    this.input.setAttribute("aria-label", "A question, for example " + (examples[0] ?? ""));
    this.input.addEventListener("keydown", (event) => this.onKey(event));
    this.result.setAttribute("role", "status");
    this.result.hidden = true;
    this.root.append(this.input);
  }

  showResult(text: string, { title, verdict, columns, rows }: QueryResult, revision: string): void {
    const table = element("table", "",
      element("thead", "", element("tr", "", ...columns.map((column) => element("th", "", column)))),
      element("tbody", "", ...rows.map((row) => this.row(columns, row))));
    this.show(element("p", `verdict ${verdict}`, element("b", "", title), element("span", "", `${text} · revision ${revision}`)),
              ...(rows.length > 0 ? [element("div", "scroller", table)] : []));
  }

  showError(error: CallError | string): void {
    if (typeof error === "string") {
      this.show(element("p", "verdict error", element("b", "", error)));
      return;
    }
    const head = element("p", "verdict error", element("b", "", error.message),
      element("span", "", [error.name, error.reason].filter((word) => word !== "").join(" · ")));
    const fields = error.fields.map(({ field, description }) =>
      element("li", "", element("code", "", field), ` ${description}`));
    this.show(head, ...(fields.length > 0 ? [element("ul", "", ...fields)] : []));
  }

  clear(): void {
    this.result.hidden = true;
    this.result.replaceChildren();
    this.listener.clear();
  }

  get hasResult(): boolean { return !this.result.hidden; }

  private show(...children: HTMLElement[]): void {
    const close = element("button", "quiet close", "\u2715");
    close.setAttribute("aria-label", "Put the answer away");
    close.addEventListener("click", () => this.clear());
    this.result.replaceChildren(close, ...children);
    this.result.hidden = false;
  }

  private row(columns: readonly string[], row: readonly string[]): HTMLElement {
    return element("tr", "", ...row.map((cell, i) => {
      if (columns[i] !== "object" || cell === "" || cell === "none" || cell.startsWith("itself")) return element("td", "", cell);
      const button = element("button", "link", cell);
      button.addEventListener("click", () => this.listener.select(cell.split(":")[0] ?? cell));
      return element("td", "", button);
    }));
  }

  private submit(): void {
    const text = this.input.value.trim();
    if (text === "") return;
    if (this.past.at(-1) !== text) this.past.push(text);
    if (this.past.length > maxKept) this.past.shift();
    this.at = this.past.length;
    try {
      this.listener.evaluate(parseQuery(text, this.world));
    } catch (error) {
      if (!(error instanceof QueryError)) throw error;
      this.clear();
      this.showError(error.message);
    }
  }

  private onKey(event: KeyboardEvent): void {
    if (event.key === "Enter") this.submit();
    else if (event.key === "ArrowUp" && this.at > 0) this.input.value = this.past[--this.at] ?? "";
    else if (event.key === "ArrowDown" && this.at < this.past.length) this.input.value = this.past[++this.at] ?? "";
    else if (event.key === "Tab" && this.input.value === "" && !event.shiftKey) this.input.value = examples[0] ?? "";
    else return;
    event.preventDefault();
  }
}
