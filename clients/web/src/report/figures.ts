// The result of the scan in numbers: the head of the page, its key figures, warnings and stages.
import type { IngestReport, StageTime } from "../world/types";
import { element, withTitle } from "../page/dom";
import { count, ms, percent, plural } from "../page/quantity";
import type { ScanRecord } from "./record";
import type { ScanObject } from "./scan_objects";

const totalOf = (stages: readonly StageTime[]): number =>
  stages.reduce((sum, stage) => sum + stage.elapsed_ms, 0);

export function heading(record: ScanRecord): HTMLElement {
  const made = new Date(record.made);
  const when = Number.isNaN(made.getTime()) ? record.made : `${made.toISOString().slice(0, 16).replace("T", " ")} UTC`;
  return element("header", "",
    element("p", "over", "Scan report"),
    element("h1", "", record.file),
    element("p", "", `${record.program} \u00b7 noise model ${record.sensor_model} \u00b7 ${when}`));
}

function figure(value: string, unit: string, label: string, meaning: string): HTMLElement {
  const number = element("dd", "", value);
  if (unit) number.append(element("small", "", `\u2009${unit}`));
  return withTitle(element("div", "", element("dt", "", label), number), meaning);
}

function share(part: string, report: IngestReport): string {
  const finite = Number(report.points_finite);
  return finite > 0 ? percent(Number(part) / finite, 2) : "0";
}

const ofKind = (scanObjects: readonly ScanObject[], kind: string): number =>
  scanObjects.filter((scanObject) => scanObject.kind === kind).length;

export function keyFigures(record: ScanRecord, scanObjects: readonly ScanObject[]): HTMLElement {
  const { report, stages } = record.response;
  const shapes = scanObjects.reduce((sum, { object }) => sum + object.shapes.length, 0);
  const triangles = scanObjects.reduce((sum, { object }) =>
    sum + object.surfaces.reduce((inner, surface) => inner + Number(surface.triangle_count), 0), 0);
  return element("dl", "figures",
    figure(count(report.points_finite), "", "Measured points", `of ${count(report.points_in)} in the scan`),
    figure(share(report.points_explained, report), "%", "Explained", "within the sensor's tolerance of the model"),
    figure(count(report.points_rejected), "", "Rejected", "isolated points that belong to nothing"),
    figure(count(ofKind(scanObjects, "support")), "", "Supports", "level surfaces that carry"),
    figure(count(ofKind(scanObjects, "object")), "", "Objects", "what stands on them"),
    figure(count(ofKind(scanObjects, "residual")), "", "Residuals", "what is neither"),
    figure(count(shapes), "", "Shapes", "primitives, those of supports included"),
    figure(count(triangles), "", "Mesh triangles", "for what no shape explains"),
    figure(ms(totalOf(stages)), "ms", "Interpretation", "all stages together"));
}

// Undefined if there are none.
export function warnings(record: ScanRecord, scanObjects: readonly ScanObject[]): HTMLElement | undefined {
  const all = [...new Set(record.response.report.warnings)];
  if (record.points.every > 1) {
    all.push(`The pictures show one of ${count(record.points.every)} measured points.`);
  }
  if (ofKind(scanObjects, "support") > 9) all.push("The ninth support and those after it share one label and one colour of points.");
  if (all.length === 0) return undefined;
  const list = element("ul", "", ...all.map((text) => element("li", "", text)));
  return element("section", "warnings", element("h2", "", plural(all.length, "note")), list);
}

export function stageBars(stages: readonly StageTime[]): HTMLElement {
  const total = totalOf(stages);
  const longest = Math.max(...stages.map((stage) => stage.elapsed_ms), 1e-9);
  const table = element("table", "stages");
  for (const stage of stages) {
    const bar = element("div", "bar");
    bar.style.setProperty("--share", String(stage.elapsed_ms / longest));
    const name = element("th", "", stage.stage);
    name.scope = "row";
    table.append(element("tr", "", name, element("td", "number", ms(stage.elapsed_ms)),
      element("td", "number", percent(total > 0 ? stage.elapsed_ms / total : 0, 0)), element("td", "bars", bar)));
  }
  const sum = element("th", "", "together");
  sum.scope = "row";
  table.append(element("tr", "sum", sum, element("td", "number", ms(total)), element("td", "number", "100"), element("td")));
  const head = element("tr", "", element("th", "", "Stage"), element("th", "number", "ms"), element("th", "number", "%"), element("th"));
  table.prepend(element("thead", "", head));
  return table;
}
