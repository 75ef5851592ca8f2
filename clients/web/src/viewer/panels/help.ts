// The keys and the forms of queries.
import { element } from "../../page/dom";
import { examples, grammar } from "../query";

const keys: readonly (readonly [key: string, meaning: string])[] = [
  ["f", "fill the picture with the selection, or with everything"],
  ["1 \u2026 6", "look from the corner, from above, from \u2212x, \u2212y, +x, +y"],
  ["arrows, + \u2212", "turn and zoom; with shift, move"],
  ["Home", "back to the first view"],
  ["drag, wheel", "turn, zoom; with the right button, move"],
  ["click", "select an object; in the tree, twice fills the picture with it"],
  ["arrows, space", "in the tree: from row to row, out of a branch and into it; hide, or show again"],
  ["h", "hide the selection, or show it again"],
  ["/", "search"],
  ["q", "ask a question"],
  ["n  x  p  s", "names, frames, the scan's points, smaller or larger points"],
  ["v", "the newest points of running sensors in the colours of their classes, in place of the scans"],
  ["o", "open the grasps that cwm-grasp --json wrote; the file can be dropped on the page too"],
  ["k", "hide the grippers of grasps, or show them again"],
  ["l", "back from an older revision to now"],
  ["t", "light or dark"],
  ["g", "save the picture as PNG"],
  ["Escape", "close, put away, select nothing"],
];

const legend: readonly (readonly [look: string, meaning: string])[] = [
  ["fitted", "measured, or given by a user"], ["completed", "supplied where nothing was measured"],
  ["unseen", "space that no sensor has seen; of the selection, into which it may extend"],
  ["mover", "around something that moves and is not modelled, such as a hand"],
  ["occluded", "dimmed: something is in front of it"],
  ["stale", "out of the sight of running sensors since"]];

export function helpDialog(): HTMLDialogElement {
  const dialog = element("dialog", "help");
  dialog.setAttribute("aria-label", "Help");
  const close = element("button", "quiet close", "\u2715");
  close.setAttribute("aria-label", "Close");
  close.addEventListener("click", () => dialog.close());
  const table = (rows: readonly (readonly [string, string])[], tag: "kbd" | "code"): HTMLElement =>
    element("table", "", ...rows.map(([name, meaning]) => element("tr", "", element("th", "", element(tag, "", name)), element("td", "", meaning))));
  dialog.append(close,
    element("h2", "", "Keys"), table(keys, "kbd"),
    element("h2", "", "Questions"),
    element("p", "", "As the command line has them, with or without dashes, in metres and radians; numbers are divided by spaces or commas."),
    table(grammar, "code"),
    element("p", "examples", ...examples.map((example) => element("code", "", example))),
    element("h2", "", "Looks"),
    element("div", "legend", ...legend.map(([look, meaning]) =>
      element("span", "entry", element("span", `look ${look}`), meaning))));
  dialog.addEventListener("click", (event) => { if (event.target === dialog) dialog.close(); });
  return dialog;
}
