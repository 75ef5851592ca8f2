// The world's axes as seen by the camera: x red, y green, z blue, drawn small in a corner.
import { Vector3, type Camera } from "three";

const namespace = "http://www.w3.org/2000/svg";
const size = 56;
const length = 18;

export interface AxisCross { svg: SVGSVGElement; turn: (camera: Camera) => void; }

function part<Tag extends "line" | "text">(tag: Tag, className: string): SVGElementTagNameMap[Tag] {
  const made = document.createElementNS(namespace, tag) as SVGElementTagNameMap[Tag];
  made.setAttribute("class", className);
  return made;
}

export function axisCross(): AxisCross {
  const svg = document.createElementNS(namespace, "svg");
  svg.setAttribute("viewBox", `${-size / 2} ${-size / 2} ${size} ${size}`);
  svg.setAttribute("class", "cross");
  svg.setAttribute("aria-hidden", "true");
  const axes = (["x", "y", "z"] as const).map((name, i) => {
    const line = part("line", `axis ${name}`);
    const text = part("text", `axis ${name}`);
    text.textContent = name;
    svg.append(line, text);
    return { line, text, direction: new Vector3().setComponent(i, 1) };
  });
  const turn = (camera: Camera): void => {
    for (const { line, text, direction } of axes) {
      const seen = direction.clone().transformDirection(camera.matrixWorldInverse);
      line.setAttribute("x2", String(length * seen.x));
      line.setAttribute("y2", String(-length * seen.y));
      text.setAttribute("x", String(1.35 * length * seen.x));
      text.setAttribute("y", String(-1.35 * length * seen.y));
    }
  };
  return { svg, turn };
}
