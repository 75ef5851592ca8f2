// The picture: renderer, light, camera, floor. Draws at most once per frame, and only after a
// change.
import {
  AmbientLight, Box3, DirectionalLight, HemisphereLight, Matrix4, PerspectiveCamera, Raycaster, Scene, Vector2, Vector3,
  WebGLRenderer,
} from "three";
import { axisCross } from "../../page/axis_cross";
import { element } from "../../page/dom";
import { DepthShading } from "../../scene/depth_shading";
import { OrbitCamera } from "../../scene/orbit_camera";
import { FramePacer, stillTime_ms, type Quality } from "./frame_pacer";
import { Grid } from "./grid";
import { Labels } from "./labels";

// A press that moves less than this is a click.
const clickSlack_px = 4;

// The time until something is drawn even if the server does not answer.
const patience_ms = 1000;

// Pixels of the picture per CSS pixel.
const drawnRatio: Record<Quality, number> = { full: Math.min(window.devicePixelRatio, 2), draft: 0.5 };

// Light comes over the viewer's left shoulder.
const lampPlace = new Vector3(-1, 1.4, 1.5);

export interface FrameFigures { frames: number; draw_calls: number; triangles: number; points: number; script_ms: number; }

// The directions of the views of keys 1 to 6.
const viewDirections: Record<string, Vector3> = {
  "1": new Vector3(-1, -0.9, 0.75),
  "2": new Vector3(0, -1e-3, 1),
  "3": new Vector3(-1, 0, 0),
  "4": new Vector3(0, -1, 0),
  "5": new Vector3(1, 0, 0),
  "6": new Vector3(0, 1, 0),
};

export class Stage {
  readonly root = element("div", "stage");
  readonly scene = new Scene();
  readonly orbit: OrbitCamera;
  readonly labels = new Labels();
  readonly grid = new Grid();
  readonly figures: FrameFigures = { frames: 0, draw_calls: 0, triangles: 0, points: 0, script_ms: 0 };
  readonly scriptTimes_ms: number[] = [];  // of the last frames
  floor_m = 0;
  isTouched = false;  // the user has chosen a view
  onFrame: () => void = () => {};       // after the commands of each picture
  onFinished: () => void = () => {};    // when it is drawn
  beforeFrame: () => void = () => {};   // updates that must be in step with the picture
  private readonly renderer = new WebGLRenderer({ antialias: false, alpha: true });  // the shading smooths
  private readonly shading = new DepthShading();
  private readonly pacer = new FramePacer();
  private fence: WebGLSync | null = null;  // behind the newest picture's commands
  private stillTimer = 0;
  private readonly lamp = new DirectionalLight(0xffffff, 1.7);
  private readonly raycaster = new Raycaster();
  private readonly cross = axisCross();
  private waiting = false;
  private isBegun = false;
  private isUpdating = false;

  // Throws if the browser has no WebGL 2.
  constructor() {
    this.renderer.setPixelRatio(drawnRatio.full);
    this.renderer.info.autoReset = false;
    this.renderer.domElement.setAttribute("aria-hidden", "true");
    this.scene.add(new HemisphereLight(0xffffff, 0x8d8d99, 1.6), new AmbientLight(0xffffff, 0.6), this.lamp, this.lamp.target);
    this.scene.add(this.grid.object);
    this.scene.matrixWorldAutoUpdate = true;
    this.orbit = new OrbitCamera(() => this.requestRender());
    this.root.append(this.renderer.domElement, this.labels.root, this.cross.svg);
    this.root.tabIndex = 0;
    this.root.setAttribute("role", "application");
    this.root.setAttribute("aria-label", "The world. Arrow keys turn, with shift they move, plus and minus zoom, f shows all, " +
      "the question mark tells the other keys.");
    this.orbit.attach(this.root, false);
    for (const touch of ["pointerdown", "wheel", "keydown"]) {
      this.root.addEventListener(touch, () => { this.isTouched = true; }, { passive: true });
    }
    new ResizeObserver(() => this.requestRender()).observe(this.root);
  }

  get camera(): PerspectiveCamera { return this.orbit.camera; }

  // Called once all permanent objects are in the scene.
  prepare(): void {
    this.shading.prepare(this.renderer, this.scene, this.camera);
    window.setTimeout(() => this.begin(), patience_ms);
  }

  // Called when there is something to draw. An empty picture before it would delay the first one.
  begin(): void {
    if (this.isBegun) return;
    this.isBegun = true;
    this.requestRender();
  }

  requestRender(): void {
    if (this.waiting || this.isUpdating || !this.isBegun) return;
    this.waiting = true;
    const draw = (): void => {
      if (this.isBusy()) {
        requestAnimationFrame(draw);
        return;
      }
      this.waiting = false;
      this.render();
    };
    requestAnimationFrame(draw);
  }

  // True if the newest picture will be drawn again, better.
  get isDraft(): boolean { return this.pacer.isDraft; }

  // True while a picture is being drawn.
  private isBusy(): boolean {
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    if (this.fence && gl.clientWaitSync(this.fence, 0, 0) === gl.TIMEOUT_EXPIRED) return true;
    if (this.fence) gl.deleteSync(this.fence);
    this.fence = null;
    if (!this.pacer.isBusy) return false;
    this.pacer.finish(performance.now());
    this.onFinished();
    window.clearTimeout(this.stillTimer);
    if (this.pacer.isDraft) this.stillTimer = window.setTimeout(() => this.requestRender(), stillTime_ms);
    return false;
  }

  private awaitPicture(): void {
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    if (this.fence) gl.deleteSync(this.fence);
    this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const look = (): void => { if (this.isBusy()) requestAnimationFrame(look); };
    requestAnimationFrame(look);
  }

  private render(wanted?: Quality): void {
    const { width, height } = this.root.getBoundingClientRect();
    if (width === 0 || height === 0) return;
    const began = performance.now();
    const paced = this.pacer.begin(began);
    const quality = wanted ?? paced;
    this.shading.setSmooth(quality === "full");
    if (this.renderer.getPixelRatio() !== drawnRatio[quality]) this.renderer.setPixelRatio(drawnRatio[quality]);
    this.isUpdating = true;  // requests from here on are served by this picture
    try {
      this.beforeFrame();
      this.fit(width, height);
    } finally {
      this.isUpdating = false;
    }
    this.renderer.info.reset();
    this.shading.render(this.renderer, this.scene, this.camera, { x: 0, y: 0, width, height }, () => {
      const { calls, triangles, points } = this.renderer.info.render;
      Object.assign(this.figures, { draw_calls: calls, triangles, points });
    });
    this.labels.place(this.camera, width, height);
    this.cross.turn(this.camera);
    this.figures.script_ms = performance.now() - began;
    this.scriptTimes_ms.push(this.figures.script_ms);
    if (this.scriptTimes_ms.length > 300) this.scriptTimes_ms.shift();
    ++this.figures.frames;
    this.awaitPicture();
    this.onFrame();
  }

  frame(boxes: readonly Box3[], view?: string): void {
    const full = boxes.filter((box) => !box.isEmpty());
    if (full.length > 0) this.orbit.frame(full, view === undefined ? undefined : viewDirections[view]);
  }

  // The position on the page of a point of the world, in CSS pixels of the window.
  onScreen(place: Vector3): { x: number; y: number; isSeen: boolean } {
    const rect = this.root.getBoundingClientRect();
    const at = place.clone().project(this.camera);
    return { x: rect.left + ((at.x + 1) / 2) * rect.width, y: rect.top + ((1 - at.y) / 2) * rect.height,
             isSeen: Math.abs(at.x) < 1 && Math.abs(at.y) < 1 && at.z < 1 };
  }

  rayAt(event: { clientX: number; clientY: number }): Raycaster {
    const rect = this.root.getBoundingClientRect();
    this.raycaster.setFromCamera(new Vector2(
      ((event.clientX - rect.left) / rect.width) * 2 - 1, 1 - ((event.clientY - rect.top) / rect.height) * 2), this.camera);
    return this.raycaster;
  }

  onClick(clicked: (event: PointerEvent) => void): void {
    let down: PointerEvent | undefined;
    this.root.addEventListener("pointerdown", (event) => { down = event; });
    this.root.addEventListener("pointerup", (event) => {
      if (!down || event.button !== 0) return;
      if (Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) < clickSlack_px) clicked(event);
      down = undefined;
    });
  }

  // The picture as a PNG, rendered again since the buffer is gone once it was shown.
  async screenshot(ground: string): Promise<Blob> {
    this.render("full");
    const canvas = document.createElement("canvas");
    canvas.width = this.renderer.domElement.width;
    canvas.height = this.renderer.domElement.height;
    const context = canvas.getContext("2d");
    if (!context) throw new Error("the browser gives no canvas to write on");
    context.fillStyle = ground;
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.drawImage(this.renderer.domElement, 0, 0);
    return new Promise((resolve, reject) => canvas.toBlob((blob) => {
      if (blob) resolve(blob);
      else reject(new Error("the browser could not write a PNG"));
    }, "image/png"));
  }

  private fit(width: number, height: number): void {
    const size = this.renderer.getSize(new Vector2());
    if (size.x !== width || size.y !== height) this.renderer.setSize(width, height, false);
    this.renderer.setClearColor(0, 0);
    this.orbit.setAspect(width / height);
    this.camera.updateMatrixWorld();
    this.grid.follow(this.camera.position, this.orbit.target, this.floor_m);
    const X = new Matrix4().extractRotation(this.camera.matrixWorld);
    this.lamp.target.position.copy(this.orbit.target);
    this.lamp.position.copy(lampPlace).applyMatrix4(X).add(this.orbit.target);
  }
}
