// The head of the page: the world, the connection, the displayed layers, and the actions.
import { element } from "../../page/dom";
import { naturalOrder } from "../../page/natural_order";
import type { World } from "../../world/stream";
import type { ConnectionState } from "../messages";

export interface Switch { key: string; title: string; label: string; isOn: boolean; turn: (isOn: boolean) => void; }

export interface Action { key: string; title: string; label: string; run: () => void; }

export function connectionText(state: ConnectionState): string {
  if (state.is === "open") return "Connected";
  if (state.is === "refused") return `Refused: ${state.why}`;
  if (state.is === "connecting" && state.why === "") return "Connecting \u2026";
  return `No connection${state.why === "" ? "" : `: ${state.why}`}, trying again \u2026`;
}

export class Toolbar {
  readonly root = element("header", "toolbar");
  private readonly worlds = element("select");
  private readonly dot = element("span", "dot");
  private readonly connection = element("span", "connection");
  private readonly tools = element("div", "tools");
  private readonly switches = new Map<string, { button: HTMLButtonElement; value: Switch }>();

  constructor(choose: (world: string) => void, refresh: () => void) {
    this.worlds.setAttribute("aria-label", "World");
    this.worlds.hidden = true;  // until there are some
    this.worlds.addEventListener("change", () => choose(this.worlds.value));
    this.worlds.addEventListener("pointerdown", refresh);
    this.connection.setAttribute("role", "status");
    this.root.append(element("span", "brand", "cwm"), this.worlds, this.dot, this.connection, this.tools);
    this.showConnection({ is: "connecting", why: "" });
  }

  showWorlds(worlds: readonly World[], chosen: string | undefined): void {
    const sorted = [...worlds].sort((a, b) => naturalOrder.compare(a.name, b.name));
    const options = sorted.map(({ name }) => {
      const option = element("option", "", name);
      option.value = name;
      return option;
    });
    if (chosen !== undefined && !worlds.some(({ name }) => name === chosen)) {
      const option = element("option", "", `${chosen} (none yet)`);
      option.value = chosen;
      options.push(option);
    }
    this.worlds.replaceChildren(...options);
    if (chosen !== undefined) this.worlds.value = chosen;
    this.worlds.hidden = options.length === 0;
  }

  showConnection(state: ConnectionState): void {
    this.dot.className = `dot ${state.is}`;
    this.root.classList.toggle("connected", state.is === "open");
    this.connection.textContent = this.connection.title = connectionText(state);
  }

  addSwitch(value: Switch): void {
    const button = this.button(value);
    button.setAttribute("aria-pressed", String(value.isOn));
    button.addEventListener("click", () => this.turn(value.key));
    this.switches.set(value.key, { button, value });
  }

  addAction(action: Action): void { this.button(action).addEventListener("click", () => action.run()); }

  // False if the key belongs to no switch.
  turn(key: string): boolean {
    const found = this.switches.get(key);
    if (!found) return false;
    found.value.isOn = !found.value.isOn;
    found.button.setAttribute("aria-pressed", String(found.value.isOn));
    found.value.turn(found.value.isOn);
    return true;
  }

  private button({ key, title, label }: { key: string; title: string; label: string }): HTMLButtonElement {
    const button = element("button", "tool", label);
    button.type = "button";
    button.title = `${title} (${key})`;
    this.tools.append(button);
    return button;
  }
}
