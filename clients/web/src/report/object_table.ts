// All objects of the scan with their parts, the parts' fit and coefficients.
import { isCompleted, type Handle, type ShapePart, type SurfacePart } from "../world/types";
import { shortName } from "../world/types";
import { element, numbers, swatch, withTitle } from "../page/dom";
import type { Highlight } from "./highlight";
import { count, mm, percent } from "../page/quantity";
import { coefficients, dimensions, position, rotation, shapeName } from "../page/shape_text";
import type { ScanObject } from "./scan_objects";

interface Column { title: string; unit?: string; numeric?: boolean; meaning?: string; }

const columns: readonly Column[] = [
  { title: "Object", meaning: "its parts beneath" },
  { title: "Kind", meaning: "of a part: fitted to points, or completed where nothing was measured" },
  { title: "On", meaning: "what supports it" },
  { title: "Size", unit: "mm", numeric: true, meaning: "of an object: its extent along the axes of its frame" },
  { title: "Points", numeric: true, meaning: "of a part: its inliers" },
  { title: "Share", unit: "%", numeric: true, meaning: "inliers among the object's points" },
  { title: "Seen", unit: "%", numeric: true, meaning: "share of the solid's surface that points cover; of a support: of its top" },
  { title: "rms", unit: "mm", numeric: true, meaning: "of the inliers' distances from the surface" },
  { title: "Worst", unit: "mm", numeric: true, meaning: "distance of an inlier from the surface" },
  { title: "Position", unit: "m", numeric: true, meaning: "of an object in the world; of a part in the object's frame" },
  { title: "Rotation" },
];

function headerCell(column: Column): HTMLElement {
  const cell = element("th", column.numeric ? "number" : "", column.title);
  cell.scope = "col";
  if (column.unit) cell.append(element("small", "", ` ${column.unit}`));
  return column.meaning ? withTitle(cell, column.meaning) : cell;
}

function row(className: string, cells: readonly (string | Node)[]): HTMLTableRowElement {
  const made = element("tr", className);
  cells.forEach((content, i) => {
    const cell = element(i === 0 ? "th" : "td", columns[i]?.numeric ? "number" : "", content);
    if (cell instanceof HTMLTableCellElement && i === 0) cell.scope = "row";
    made.append(cell);
  });
  return made;
}

function objectRow(scanObject: ScanObject): HTMLTableRowElement {
  const { object } = scanObject;
  const pose = object.x_world_object;
  const size = scanObject.size.toArray().map((m) => mm(m, 0)).join(" × ");
  const name = element("span", "name", swatch(scanObject.color), object.name || "an object of the user");
  const reachable = object.reachable === undefined ? "" : object.reachable ? ", in reach" : ", out of reach";
  return row("object", [
    name, scanObject.kind + reachable, object.supported_by, size,
    object.point_count === "0" ? "" : count(object.point_count), "", "", "", "",
    pose ? numbers(position(pose)) : "", pose ? rotation(pose) : ""]);
}

function shapeRow(part: ShapePart): HTMLTableRowElement {
  const { fit } = part;
  const pose = part.x_object_shape;
  const turned = pose ? rotation(pose) : "";
  const shifted = pose !== undefined && Math.hypot(pose.tx_m, pose.ty_m, pose.tz_m) > 5e-4;
  return row("part", [
    element("span", "part-name", shapeName(part)),
    element("span", isCompleted(part) ? "role completed" : "role", shortName(part.role, "PART_ROLE")), "",
    dimensions(part),
    fit ? count(fit.inlier_count) : "", fit ? percent(fit.inlier_ratio) : "",
    fit ? percent(fit.observed_fraction) : "", fit ? mm(fit.rms_m, 2) : "", fit ? mm(fit.max_residual_m, 1) : "",
    shifted || turned ? numbers(position(pose as NonNullable<typeof pose>)) : "", turned]);
}

// The coefficients under their part, in columns that are the same for every part.
function coefficientRow(part: ShapePart): HTMLTableRowElement | undefined {
  const all = coefficients(part);
  if (all.length === 0) return undefined;
  const list = element("div", "coefficients");
  for (const { name, symbol, value, unit, sigma, exact } of all) {
    const [letter, index] = symbol.split("_");
    const letters = withTitle(element("i", "", letter ?? ""), name);
    if (index) letters.append(element("sub", "", index));
    list.append(withTitle(element("div", "", letters, element("span", "value", value), element("small", "", unit),
      element("span", "sigma", sigma)), String(exact)));
  }
  const cell = element("td", "", list);
  cell.colSpan = columns.length;
  return element("tr", "fit", cell);
}

function surfaceRow(surface: SurfacePart): HTMLTableRowElement {
  return row("part", [
    element("span", "part-name", "surface"), surface.watertight ? "mesh, watertight" : "mesh", "",
    Number(surface.triangle_count) === 1 ? "1 triangle" : `${count(surface.triangle_count)} triangles`,
    count(surface.point_count), "", "", "", "", "", ""]);
}

function handleRow(handle: Handle): HTMLTableRowElement {
  const { size_x_m: x, size_y_m: y, size_z_m: z } = handle.bounds.box;
  return row("part", [
    element("span", "part-name", "handle"),
    handle.shape_index < 0 ? "of the surface" : `of part ${handle.shape_index + 1}`, "",
    [x, y, z].map((m) => mm(m)).join("\u2009×\u2009"), count(handle.point_count), "", "", "", "",
    numbers(position(handle.bounds.x_object_box)), rotation(handle.bounds.x_object_box)]);
}

function body(scanObject: ScanObject, highlight: Highlight): HTMLTableSectionElement {
  const { object } = scanObject;
  const section = element("tbody", "", objectRow(scanObject));
  section.tabIndex = 0;
  for (const part of object.shapes) {
    section.append(shapeRow(part));
    const fit = coefficientRow(part);
    if (fit) section.append(fit);
  }
  section.append(...object.surfaces.map(surfaceRow), ...object.handles.map(handleRow));
  section.addEventListener("pointerenter", () => highlight.hover(scanObject.index));
  section.addEventListener("pointerleave", () => highlight.hover(undefined));
  section.addEventListener("click", () => highlight.pick(scanObject.index));
  section.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    highlight.pick(scanObject.index);
  });
  return section;
}

export function objectTable(scanObjects: readonly ScanObject[], highlight: Highlight): HTMLElement {
  const head = element("thead", "", element("tr", "", ...columns.map(headerCell)));
  const bodies = scanObjects.map((scanObject) => body(scanObject, highlight));
  highlight.onChange(() => bodies.forEach((section, i) => {
    section.classList.toggle("active", highlight.active === i);
    section.setAttribute("aria-selected", String(highlight.pinned === i));
  }));
  const scroller = element("div", "scroller", element("table", "objects", head, ...bodies));
  scroller.tabIndex = 0;
  scroller.setAttribute("role", "region");
  scroller.setAttribute("aria-label", "Objects and coefficients");
  return scroller;
}
