// Explains the looks in the pictures, and how to turn them.
import { element } from "../page/dom";

function entry(look: string, text: string): HTMLElement {
  return element("span", "entry", element("span", `look ${look}`), text);
}

export function legend(home: () => void): HTMLElement {
  const back = element("button", "", "Reset view");
  back.type = "button";
  back.addEventListener("click", home);
  return element("div", "legend",
    entry("fitted", "measured"), entry("completed", "completed, not measured"), entry("mesh", "mesh"),
    entry("point", "points"),
    element("span", "hint mouse", "Drag to turn, right drag to move; click a picture, then the wheel zooms"),
    element("span", "hint touch", "Drag to turn, two fingers move and zoom"), back);
}
