// The pictures side by side: one canvas behind four panes, one camera for all.
import { AmbientLight, Box3, Color, DirectionalLight, HemisphereLight, Material, Mesh, Object3D, Raycaster,
         Vector2, Vector3, WebGLRenderer } from "three";
import { DepthShading, type Region } from "../scene/depth_shading";
import { OrbitCamera } from "../scene/orbit_camera";
import { axisCross } from "../page/axis_cross";
import { element } from "../page/dom";
import type { Highlight } from "./highlight";
import type { Picture } from "./pictures";
import type { ScanObject } from "./scan_objects";

// `view` is the element that is drawn into; a title bar is above it.
export interface Pane { picture: Picture; view: HTMLElement; calls: number; triangles: number; points: number; }

// How far objects other than the highlighted one fade towards the background.
const dimming = 0.82;

// A press that moves less than this is a click.
const clickSlack_px = 4;

interface BaseStyle { color: Color; opacity: number; }

// Light comes over the viewer's left shoulder, in every pane.
const lampPlace = new Vector3(-1, 1.4, 1.5);

function light(picture: Picture): void {
  picture.scene.add(new HemisphereLight(0xffffff, 0x8d8d99, 1.6), new AmbientLight(0xffffff, 0.35));
}

export class Gallery {
  readonly root = element("section", "gallery");
  readonly panes: Pane[];
  readonly orbit: OrbitCamera;
  private readonly renderer: WebGLRenderer;
  private readonly lamp = new DirectionalLight(0xffffff, 1.9);
  private readonly shading = new DepthShading();
  private readonly tip = element("div", "tip");
  private readonly crosses: ((camera: OrbitCamera["camera"]) => void)[] = [];
  private readonly raycaster = new Raycaster();
  private waiting = false;

  // Throws if the browser has no WebGL 2.
  constructor(pictures: readonly Picture[], private readonly scanObjects: readonly ScanObject[],
              private readonly highlight: Highlight) {
    this.renderer = new WebGLRenderer({ antialias: false, alpha: true });  // the shading smooths
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.info.autoReset = false;
    this.renderer.setScissorTest(true);
    this.renderer.domElement.setAttribute("aria-hidden", "true");
    this.orbit = new OrbitCamera(() => this.requestRender());
    this.tip.setAttribute("role", "status");
    this.root.setAttribute("aria-label", "Pictures of the scan");
    this.root.append(this.renderer.domElement);
    this.panes = pictures.map((picture) => this.addPane(picture));
    this.root.append(this.tip);
    highlight.onChange(() => this.showHighlight());
    new ResizeObserver(() => this.requestRender()).observe(this.root);
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.showHighlight());
  }

  // All pictures, now. The gallery must be in the document.
  render(): void {
    const root = this.root.getBoundingClientRect();
    if (root.width === 0 || root.height === 0) return;
    this.renderer.setSize(root.width, root.height, false);
    this.renderer.setClearColor(0, 0);
    for (const pane of this.panes) this.renderPane(pane, root);
    for (const turn of this.crosses) turn(this.orbit.camera);
  }

  look(bounds: Box3, sensor: Vector3): void { this.orbit.setHome(bounds, sensor); }

  requestRender(): void {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.render();
    });
  }

  private addPane(picture: Picture): Pane {
    light(picture);
    const figure = element("figure", "pane");
    const caption = element("figcaption", "", element("b", "", picture.title), element("span", "", picture.caption));
    const enlarge = element("button", "enlarge", "\u2922");
    enlarge.type = "button";
    enlarge.title = "One picture or all four";
    enlarge.setAttribute("aria-label", `Enlarge ${picture.title}`);
    enlarge.setAttribute("aria-pressed", "false");
    enlarge.addEventListener("click", () => this.toggleEnlarged(figure, enlarge));
    const cross = axisCross();
    this.crosses.push(cross.turn);
    const view = element("div", "view");
    view.tabIndex = 0;
    view.setAttribute("role", "application");
    view.setAttribute("aria-label", `${picture.title}: ${picture.caption}. Arrow keys turn, with shift they move, ` +
      "plus and minus zoom, Home goes back.");
    caption.append(enlarge);
    view.append(cross.svg);
    figure.append(caption, view);
    this.root.append(figure);
    this.orbit.attach(view);
    this.addPicking(view);
    return { picture, view, calls: 0, triangles: 0, points: 0 };
  }

  private toggleEnlarged(figure: HTMLElement, button: HTMLElement): void {
    const enlarged = !figure.classList.contains("enlarged");
    this.root.classList.toggle("single", enlarged);
    figure.classList.toggle("enlarged", enlarged);
    button.setAttribute("aria-pressed", String(enlarged));
    figure.scrollIntoView({ block: "nearest" });
    this.requestRender();
  }

  private addPicking(view: HTMLElement): void {
    let pressed: { x: number; y: number } | undefined;
    view.addEventListener("pointerdown", (event) => { pressed = { x: event.clientX, y: event.clientY }; });
    view.addEventListener("pointermove", (event) => {
      if (event.buttons !== 0) return this.hideTip();
      this.showTip(event, this.objectIndexAt(view, event));
    });
    view.addEventListener("pointerleave", () => {
      this.highlight.hover(undefined);
      this.hideTip();
    });
    view.addEventListener("pointerup", (event) => {
      if (!pressed) return;
      if (Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) > clickSlack_px) return;
      const index = this.objectIndexAt(view, event);
      if (index !== undefined || this.highlight.pinned !== undefined) this.highlight.pick(index);
    });
  }

  // All panes share the camera, so the object of the hybrid model at this place is the one shown in
  // the pane.
  private objectIndexAt(view: HTMLElement, event: PointerEvent): number | undefined {
    const rect = view.getBoundingClientRect();
    const place = new Vector2(
      (2 * (event.clientX - rect.left)) / rect.width - 1, 1 - (2 * (event.clientY - rect.top)) / rect.height);
    this.orbit.setAspect(rect.width / rect.height);
    this.raycaster.setFromCamera(place, this.orbit.camera);
    const hybrid = this.panes[this.panes.length - 1] as Pane;
    const hits = this.raycaster.intersectObjects(hybrid.picture.scene.children, true);
    const hit = hits.find(({ object }) => object instanceof Mesh);
    for (let node: Object3D | null = hit?.object ?? null; node; node = node.parent) {
      const index: unknown = node.userData["objectIndex"];
      if (typeof index === "number") return index;
    }
    return undefined;
  }

  private showTip(event: PointerEvent, index: number | undefined): void {
    this.highlight.hover(index);
    const scanObject = index === undefined ? undefined : this.scanObjects[index];
    if (!scanObject) return this.hideTip();
    const rect = this.root.getBoundingClientRect();
    this.tip.textContent = scanObject.object.name;
    this.tip.style.setProperty("--x", `${event.clientX - rect.left}px`);
    this.tip.style.setProperty("--y", `${event.clientY - rect.top}px`);
    this.tip.classList.add("shown");
  }

  private hideTip(): void { this.tip.classList.remove("shown"); }

  private showHighlight(): void {
    const active = this.highlight.active;
    const background = new Color(getComputedStyle(this.root).getPropertyValue("--picture").trim());
    for (const { picture } of this.panes) {
      for (const child of picture.scene.children) {
        if (typeof child.userData["objectIndex"] !== "number") continue;
        const behind = active !== undefined && child.userData["objectIndex"] !== active;
        child.traverse((node) => {
          const material = (node as Mesh).material as Material | Material[] | undefined;
          for (const one of material === undefined ? [] : [material].flat()) dim(one, behind, background);
        });
      }
    }
    this.requestRender();
  }

  private renderPane(pane: Pane, root: DOMRect): void {
    const rect = pane.view.getBoundingClientRect();
    if (rect.width === 0 || rect.height === 0) return;
    this.orbit.setAspect(rect.width / rect.height);
    const { camera } = this.orbit;
    camera.updateMatrixWorld();
    this.lamp.position.copy(lampPlace).applyQuaternion(camera.quaternion);
    pane.picture.scene.add(this.lamp);
    const region: Region =
      { x: rect.left - root.left, y: root.bottom - rect.bottom, width: rect.width, height: rect.height };
    this.renderer.info.reset();
    this.shading.render(this.renderer, pane.picture.scene, camera, region, () => {
      const { calls, triangles, points } = this.renderer.info.render;
      Object.assign(pane, { calls, triangles, points });
    });
  }
}

function dim(material: Material, behind: boolean, background: Color): void {
  const colored = material as Material & { color?: Color };
  if (!colored.color) return;
  const base = (material.userData["base"] ??= { color: colored.color.clone(), opacity: material.opacity }) as BaseStyle;
  colored.color.copy(base.color);
  if (behind) colored.color.lerp(background, dimming);
  material.opacity = behind && material.transparent ? base.opacity * (1 - dimming) : base.opacity;
}
