// A camera shared by all panes, which any of them can turn with the mouse, by touch and by keys.
import { Box3, PerspectiveCamera, Spherical, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const fieldOfView_deg = 35;  // upwards, in a pane of the usual aspect
const widerThanHigh = 1.5;     // the usual aspect

// The direction of the first view: beside the sensor, so that depth is visible, and never
// horizontal or vertical.
const besideSensor_rad = 0.35;
const leastPolar_rad = 0.55;
const mostPolar_rad = 1.2;

const keyTurn_rad = Math.PI / 36;
const keyZoom = 0.9;
const keyShift = 1 / 16;  // of a pane's height, if its aspect is the usual one

// three.js measures polar angles from y; our up axis is z.
const toYUp = (v: Vector3): Vector3 => new Vector3(v.x, v.z, -v.y);
const toZUp = (v: Vector3): Vector3 => new Vector3(v.x, -v.z, v.y);

// Room around what is shown at first.
const margin = 1.12;

// Each step at least halves the error; a few steps reach a pixel.
const fittingSteps = 8;

interface View { target: Vector3; position: Vector3; }

function cornersOf(bounds: Box3): Vector3[] {
  return [0, 1, 2, 3, 4, 5, 6, 7].map((corner) => new Vector3(
    corner & 1 ? bounds.max.x : bounds.min.x, corner & 2 ? bounds.max.y : bounds.min.y,
    corner & 4 ? bounds.max.z : bounds.min.z));
}

// The nearest view along `-direction` in which a pane of the usual aspect contains all corners,
// centred on them. The corners are within `bounds`. three.js's controls only move a camera; none of
// its add-ons fits a view to a scene.
function fittingView(bounds: Box3, direction: Vector3, corners = cornersOf(bounds)): View {
  const right = new Vector3(0, 0, 1).cross(direction).normalize();
  const up = direction.clone().cross(right);
  const slope = Math.tan((fieldOfView_deg * Math.PI) / 360) / margin;
  const target = bounds.getCenter(new Vector3());
  const radius = Math.max(bounds.getSize(new Vector3()).length() / 2, 0.01);  // never inside, even
                                                                              // for a single point
  let distance = radius / slope;
  for (let step = 0; step < fittingSteps; ++step) {
    const seen = new Box3();
    for (const corner of corners) {
      const p = corner.clone().sub(target);
      const depth = Math.max(distance - p.dot(direction), radius / 100);
      seen.expandByPoint(new Vector3(p.dot(right) / depth, p.dot(up) / depth, 0));
    }
    const middle = seen.getCenter(new Vector3()).multiplyScalar(distance);
    target.addScaledVector(right, middle.x).addScaledVector(up, middle.y);
    const size = seen.getSize(new Vector3()).divideScalar(2);
    distance *= Math.max(size.x / widerThanHigh, size.y, 1e-3) / slope;
    distance = Math.max(distance, 1.1 * radius);
  }
  return { target, position: target.clone().addScaledVector(direction, distance) };
}

export class OrbitCamera {
  readonly camera = new PerspectiveCamera(fieldOfView_deg);
  readonly target = new Vector3();
  private readonly controls: OrbitControls[] = [];

  constructor(private readonly changed: () => void) {
    this.camera.up.set(0, 0, 1);
  }

  // Shows all of `bounds` from near the sensor's side, and makes this view the home.
  setHome(bounds: Box3, sensor: Vector3): void {
    const from = new Spherical().setFromVector3(toYUp(sensor.clone().sub(bounds.getCenter(new Vector3()))));
    from.radius = 1;
    from.theta += besideSensor_rad;
    from.phi = Math.min(Math.max(from.phi, leastPolar_rad), mostPolar_rad);
    this.look(fittingView(bounds, toZUp(new Vector3().setFromSpherical(from))));
    this.keepHome();
  }

  // Makes the present view the target of the Home key; the first element's controls remember it.
  keepHome(): void { this.controls[0]?.saveState(); }

  home(): void { this.controls[0]?.reset(); }

  // Shows all of the boxes, which must not be empty, from the present direction or along
  // `-direction`.
  frame(boxes: readonly Box3[], direction?: Vector3): void {
    const from = direction ?? this.camera.position.clone().sub(this.target);
    const all = boxes.reduce((sum, box) => sum.union(box), new Box3());
    this.look(fittingView(all, from.clone().normalize(), boxes.flatMap(cornersOf)));
  }

  // Lets a pane's element turn the camera. If the page scrolls, the wheel zooms only while the
  // element has the focus.
  attach(element: HTMLElement, scrolls = true): void {
    const controls = new OrbitControls(this.camera, element);
    controls.target = this.target;
    controls.zoomToCursor = true;
    controls.enableZoom = !scrolls;
    controls.addEventListener("change", this.changed);
    this.controls.push(controls);
    if (scrolls) {
      element.addEventListener("focus", () => { controls.enableZoom = true; });
      element.addEventListener("blur", () => { controls.enableZoom = false; });
    }
    element.addEventListener("pointerdown", () => element.focus({ preventScroll: true }));
    element.addEventListener("keydown", (event) => this.onKey(event, controls));
  }

  // Adapts the camera to a pane's aspect; a narrower pane than usual shows the same width.
  setAspect(aspect: number): void {
    this.camera.aspect = aspect;
    const half = Math.tan((fieldOfView_deg * Math.PI) / 360);
    this.camera.fov = (2 * Math.atan((half * widerThanHigh) / Math.min(aspect, widerThanHigh)) * 180) / Math.PI;
    const distance = this.camera.position.distanceTo(this.target);
    this.camera.near = distance / 200;
    this.camera.far = distance * 200;
    this.camera.updateProjectionMatrix();
  }

  private look(view: View): void {
    this.camera.position.copy(view.position);
    this.target.copy(view.target);
    this.camera.lookAt(this.target);
    this.changed();
  }

  // The keys of OrbitControls move where ours turn, and do not zoom, so only its moves are used.
  private onKey(event: KeyboardEvent, controls: OrbitControls): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrows: Record<string, [number, number]> = {
      ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const arrow = arrows[event.key];
    if (arrow && event.shiftKey) {
      const { clientWidth, clientHeight } = event.currentTarget as HTMLElement;
      const step_px = keyShift * Math.min(clientWidth / widerThanHigh, clientHeight);
      controls.pan(-arrow[0] * step_px, arrow[1] * step_px);
    } else if (arrow?.[0]) controls.rotateLeft(-arrow[0] * keyTurn_rad);
    else if (arrow) controls.rotateUp(arrow[1] * keyTurn_rad);
    else if (event.key === "+" || event.key === "=") controls.dollyIn(keyZoom);
    else if (event.key === "-") controls.dollyOut(keyZoom);
    else if (event.key === "Home") this.home();
    else return;
    this.changed();  // OrbitControls does not tell of moves below a millimetre
    event.preventDefault();
  }
}
