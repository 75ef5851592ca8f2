// The details of the selected object.
import { element, numbers, swatch } from "../../page/dom";
import { count, degrees, fixed, mm, percent } from "../../page/quantity";
import { coefficients, dimensions, position, rotation, shapeName } from "../../page/shape_text";
import { isCompleted, shortName, type FitQuality, type OrientedBox, type Pose, type ShapePart, type WorldObject }
  from "../../world/types";
import type { PairRule } from "../../world/stream";
import type { RobotModel } from "../feed";
import { motionWord, visibilityWord } from "../object_status";
import { isRobot, type SceneObject } from "../scene_objects";

function fact(term: string, ...value: (Node | string)[]): HTMLElement[] {
  return [element("dt", "", term), element("dd", "", ...value)];
}

const facts = (...all: HTMLElement[][]): HTMLElement => element("dl", "facts", ...all.flat());

const words = (value: string, type: string): string => shortName(value, type).replaceAll("_", " ");

function poseFacts(pose: Pose | undefined): HTMLElement[][] {
  if (!pose) return [fact("Position", "0  0  0 m")];
  const turned = rotation(pose);
  return [fact("Position", numbers(position(pose)), " m"), ...(turned ? [fact("Rotation", turned)] : [])];
}

function fitFacts(fit: FitQuality): HTMLElement {
  return facts(
    fact("rms", `${mm(fit.rms_m, 2)} mm`), fact("largest residual", `${mm(fit.max_residual_m, 2)} mm`),
    fact("inliers", `${count(fit.inlier_count)} (${percent(fit.inlier_ratio)} %)`),
    fact("observed", `${percent(fit.observed_fraction, 0)} %`));
}

// How far the part may go on where nothing was seen, which the picture shows with dots.
function hiddenText(part: ShapePart, { box }: OrientedBox): string {
  const sizes = [part.box?.size_x_m ?? 0, part.box?.size_y_m ?? 0, part.box?.size_z_m ?? part.plate?.thickness_m ?? 0];
  const more_m = Math.max(0, ...[box.size_x_m, box.size_y_m, box.size_z_m].map((size_m, i) =>
    (sizes[i] === 0 ? 0 : size_m - (sizes[i] ?? 0))));
  return `Unseen beside it: it may be up to ${mm(more_m)} mm larger, within ` +
    `${mm(box.size_x_m)}\u2009\u00d7\u2009${mm(box.size_y_m)}\u2009\u00d7\u2009${mm(box.size_z_m)} mm (dots)`;
}

function shapeSection(part: ShapePart, index: number): HTMLElement {
  const size = dimensions(part);
  const role = element("span", `role ${isCompleted(part) ? "completed" : "fitted"}`, isCompleted(part) ? "completed" : part.fit ? "fitted" : "given");
  const section = element("section", "part", element("h3", "", `${index} · ${shapeName(part)}`, role));
  if (size) section.append(element("p", "size", part.plate ? size : `${size} mm`));
  const table = element("table", "coefficients");
  for (const { name, value, sigma, unit } of coefficients(part)) {
    const cell = element("th", "", name);
    cell.scope = "row";
    table.append(element("tr", "", cell, element("td", "number", value), element("td", "unit", unit), element("td", "sigma", sigma)));
  }
  if (table.childElementCount > 0) section.append(table);
  if (part.fit) section.append(fitFacts(part.fit));
  if (part.hidden) section.append(element("p", "hidden-space", hiddenText(part, part.hidden)));
  return section;
}

// "2026-01-02T03:04:05.678Z" without the fraction and the separators.
const time = (stamp: string): string => stamp.replace("T", " ").replace(/(\.\d+)?Z$/, " UTC");

function objectFacts(object: WorldObject, kindWord: string): HTMLElement {
  return facts(
    fact("Kind", kindWord), fact("Owner", words(object.owner, "OWNER")), fact("State", words(object.state, "OBJECT_STATE")),
    ...sensorFacts(object), ...poseFacts(object.x_world_object),
    ...(object.supported_by ? [fact("Stands on", object.supported_by)] : []),
    ...(object.attached_to ? [fact("Attached to", object.attached_to)] : []),
    ...(object.margin_m > 0 ? [fact("Margin", `${mm(object.margin_m)} mm`)] : []),
    ...(Number(object.point_count) > 0 ? [fact("Points", count(object.point_count))] : []),
    ...(object.reachable === undefined ? [] : [fact("Reachable", object.reachable ? "yes" : "no")]),
    ...(object.last_observed ? [fact("Last seen", time(object.last_observed))] : []),
    fact("Revisions", `made ${count(object.create_revision)}, shape ${count(object.geometry_revision)}, pose ${count(object.pose_revision)}`));
}

// The facts of running sensors about it.
function sensorFacts(object: WorldObject): HTMLElement[][] {
  const motion = motionWord(object);
  const visibility = visibilityWord(object);
  return [
    ...(motion ? [fact("Motion", motion)] : []),
    ...(visibility ? [fact("Visibility", visibility)] : []),
    ...(object.identity_certain === false ? [fact("Identity", "may be swapped with another one of its shape")] : []),
    ...(object.carried_by ? [fact("Carried by", object.carried_by)] : [])];
}

function meshLine(kind: string, text: string, hash: string): HTMLElement {
  const section = element("section", "part", element("h3", "", kind), element("p", "size", text));
  if (hash) {
    const code = element("code", "hash", hash.slice(0, 12));
    code.title = hash;
    section.append(code);
  }
  return section;
}

function objectSections(object: WorldObject): HTMLElement[] {
  return [
    ...object.shapes.map(shapeSection),
    ...object.surfaces.map(({ hash, vertex_count, triangle_count, watertight, point_count }) => meshLine("Surface",
      `${count(triangle_count)} triangles, ${count(vertex_count)} vertices, ${watertight ? "watertight" : "open"}, ` +
      `for ${count(point_count)} points`, hash)),
    ...object.handles.map(({ shape_index, point_count, hash, bounds: { box } }) => meshLine("Handle",
      `${shape_index < 0 ? "of the surface" : `on shape ${shape_index}`}, ${count(point_count)} points, ` +
      `${mm(box.size_x_m)} × ${mm(box.size_y_m)} × ${mm(box.size_z_m)} mm`, hash))];
}

function robotSections({ robot, links }: RobotModel): HTMLElement[] {
  const table = element("table", "joints");
  robot.variables.forEach((variable, i) => {
    const value = robot.state[i] ?? 0;
    const { lower, upper } = variable;
    const name = element("th", "", variable.name);
    name.scope = "row";
    const row = element("tr", "", name, element("td", "number", fixed(value, 3)));
    const cell = element("td", "limits");
    if (lower !== undefined && upper !== undefined && upper > lower) {
      const meter = element("meter");
      meter.min = lower;
      meter.max = upper;
      meter.value = value;
      meter.title = `${degrees(lower, 1)}° to ${degrees(upper, 1)}° where it turns`;
      cell.append(meter);
    }
    row.append(cell);
    table.append(row);
  });
  return [
    facts(fact("Links", count(links.length)), ...poseFacts(robot.x_world_base), fact("State revision", count(robot.state_revision))),
    element("section", "part", element("h3", "", "Joints, rad or m"), table)];
}

const isAbout = (name: string, { pair: { a, b } }: PairRule): boolean => a.name === name || b.name === name;

function rulesSection(name: string, about: readonly PairRule[]): HTMLElement[] {
  if (about.length === 0) return [];
  const list = element("ul", "rules", ...about.map(({ pair: { a, b }, allowed, margin_m, check }) => {
    const other = a.name === name ? b : a;
    const whom = `${other.name === "*" ? "everything" : other.name}${other.link ? `:${other.link}` : ""}`;
    return element("li", "", [allowed ? `may touch ${whom}` : "", check ? `${a.link} is checked against ${b.link}` : "",
      margin_m === undefined ? "" : `margin ${mm(margin_m)} mm to ${whom}`]
      .filter((text) => text !== "").join(", "));
  }));
  return [element("section", "part", element("h3", "", "Rules"), list)];
}

// chosen: the body of what moves is written at most so often, which can still be read.
const bodyPeriod_ms = 100;

export class Details {
  readonly root = element("section", "details");
  private readonly head = element("header");
  private readonly body = element("div");
  private shown: SceneObject | undefined;
  private rules: readonly PairRule[] = [];  // about it
  private written_ms = 0;  // when the body was
  private timer = 0;       // of a body that is to be written; 0: none

  constructor(private readonly listener: { close: () => void; frame: (name: string) => void }) {
    this.root.setAttribute("aria-label", "Details of the selection");
    this.root.hidden = true;
    this.root.append(this.head, this.body);
  }

  // Keeps unchanged parts, and the buttons as long as the name stays, so that focus and scroll
  // position are kept.
  show(sceneObject: SceneObject | undefined, rules: ReadonlyMap<string, PairRule>): void {
    const before = this.shown;
    const about = sceneObject ? [...rules.values()].filter((rule) => isAbout(sceneObject.name, rule)) : [];
    const hasSameRules = about.length === this.rules.length && about.every((rule, i) => rule === this.rules[i]);
    if (sceneObject?.source === before?.source && hasSameRules) return;
    this.shown = sceneObject;
    this.rules = about;
    this.root.hidden = sceneObject === undefined;
    if (!sceneObject) return;
    const isOther = sceneObject.name !== before?.name;
    if (isOther || sceneObject.color !== before.color) this.writeHead(sceneObject);
    if (isOther || !hasSameRules) this.writeNow();
    else this.refresh();
  }

  // Called if the displayed object was changed in place.
  refresh(): void {
    if (this.timer !== 0) return;
    const wait_ms = this.written_ms + bodyPeriod_ms - performance.now();
    if (wait_ms <= 0) this.writeNow();
    else this.timer = window.setTimeout(() => this.writeNow(), wait_ms);
  }

  private writeNow(): void {
    window.clearTimeout(this.timer);
    this.timer = 0;
    this.written_ms = performance.now();
    if (this.shown) this.writeBody(this.shown);
  }

  private writeHead({ name, color }: SceneObject): void {
    const frame = element("button", "quiet", "Frame");
    frame.title = "Move the camera so that it fills the picture (f)";
    frame.addEventListener("click", () => this.listener.frame(name));
    const close = element("button", "quiet", "\u2715");
    close.setAttribute("aria-label", "Close the details");
    close.addEventListener("click", () => this.listener.close());
    this.head.replaceChildren(element("h2", "", swatch(color), element("span", "", name)), frame, close);
  }

  private writeBody({ name, kind, source }: SceneObject): void {
    this.body.replaceChildren(
      ...(isRobot(source) ? robotSections(source) : [objectFacts(source, kind === "user" ? "user's object" : kind), ...objectSections(source)]),
      ...rulesSection(name, this.rules));
  }
}
