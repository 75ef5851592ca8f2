// The points of sensors' newest frames in the colours of their classes. A frame is copied into the
// buffers of the one before, so that frames leave no garbage.
import {
  BufferAttribute, BufferGeometry, Color, DynamicDrawUsage, Group, Points, PointsMaterial, type Vector3,
} from "three";
import type { SensorPoints } from "../../world/stream";
import { pixelClasses } from "../pixel_classes";

const pointBytes = 12;
const smallest = 4096;

// Class 0 is of no point.
const classColors = [new Color("#000000"), ...pixelClasses.map(({ color }) => new Color(color))];

function classMaterial(size_px: number): PointsMaterial {
  const material = new PointsMaterial({ size: size_px, sizeAttenuation: false });
  material.onBeforeCompile = (shader) => {
    shader.uniforms["classColors"] = { value: classColors };
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", `#include <common>
        attribute float pixelClass;
        uniform vec3 classColors[${classColors.length}];
        varying vec3 classColor;`)
      .replace("#include <color_vertex>", `classColor = classColors[int(min(pixelClass, ${classColors.length - 1}.0) + 0.5)];`);
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", "#include <common>\nvarying vec3 classColor;")
      .replace("#include <color_fragment>", "diffuseColor.rgb = classColor;");
  };
  material.customProgramCacheKey = () => "pixel classes";
  return material;
}

// Buffers for the points of one sensor, which grow when a frame has more.
export class PointBuffers {
  readonly points: Points;
  private readonly material: PointsMaterial;
  private capacity = 0;
  private places = new Float32Array();
  private placeBytes = new Uint8Array();
  private classes = new Uint8Array();
  count = 0;

  constructor(size_px: number) {
    this.material = classMaterial(size_px);
    this.points = new Points(new BufferGeometry(), this.material);
    this.points.frustumCulled = false;  // its bounds would be computed for every frame
    this.points.matrixAutoUpdate = false;
    this.reserve(smallest);
  }

  setSize(size_px: number): void { this.material.size = size_px; }

  // Throws if the two do not describe the same number of points.
  set({ sensor, points, classes }: Pick<SensorPoints, "sensor" | "points" | "classes">): void {
    if (points.length !== pointBytes * classes.length) {
      throw new Error(`points: are ${points.length} bytes of sensor ${sensor}, must be ${pointBytes} for each of ${classes.length} classes`);
    }
    this.count = classes.length;
    this.reserve(this.count);
    this.placeBytes.set(points);
    this.classes.set(classes);
    const { geometry } = this.points;
    for (const name of ["position", "pixelClass"] as const) {
      const attribute = geometry.getAttribute(name) as BufferAttribute;
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(0, attribute.itemSize * this.count);
      attribute.needsUpdate = true;
    }
    geometry.setDrawRange(0, this.count);
  }

  placeOf(index: number, to: Vector3): Vector3 { return to.fromArray(this.places, 3 * index); }

  classOf(index: number): number { return this.classes[index] ?? 0; }

  dispose(): void {
    this.points.geometry.dispose();
    this.material.dispose();
  }

  private reserve(count: number): void {
    if (count <= this.capacity) return;
    this.capacity = Math.max(count, 2 * this.capacity);
    this.places = new Float32Array(3 * this.capacity);
    this.placeBytes = new Uint8Array(this.places.buffer);
    this.classes = new Uint8Array(this.capacity);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(this.places, 3).setUsage(DynamicDrawUsage));
    geometry.setAttribute("pixelClass", new BufferAttribute(this.classes, 1).setUsage(DynamicDrawUsage));
    this.points.geometry.dispose();
    this.points.geometry = geometry;
  }
}

export class LivePoints {
  readonly root = new Group();
  private readonly bySensor = new Map<string, PointBuffers>();
  private size_px = 2;

  get pointCount(): number { return [...this.bySensor.values()].reduce((sum, { count }) => sum + count, 0); }

  setSize(size_px: number): void {
    this.size_px = size_px;
    for (const buffers of this.bySensor.values()) buffers.setSize(size_px);
  }

  set(frame: SensorPoints): void {
    let buffers = this.bySensor.get(frame.sensor);
    if (!buffers) {
      buffers = new PointBuffers(this.size_px);
      this.bySensor.set(frame.sensor, buffers);
      this.root.add(buffers.points);
    }
    buffers.set(frame);
  }

  // Drops the points of all other sensors.
  keep(sensors: ReadonlySet<string>): void {
    for (const [sensor, buffers] of this.bySensor) {
      if (sensors.has(sensor)) continue;
      this.root.remove(buffers.points);
      buffers.dispose();
      this.bySensor.delete(sensor);
    }
  }
}
