// The floor as a grid that fades into the distance: one plane, lines drawn by its shader, as wide as a pixel.
import { Color, DoubleSide, Mesh, PlaneGeometry, ShaderMaterial, Vector3 } from "three";

const vertexShader = `
  varying vec2 place;
  void main() {
    vec4 world = modelMatrix * vec4(position, 1.0);
    place = world.xy;
    gl_Position = projectionMatrix * viewMatrix * world;
  }
`;

const fragmentShader = `
  uniform float cell_m;
  uniform float reach_m;
  uniform vec3 center;
  uniform vec3 ink;
  varying vec2 place;

  float line(float step_m) {
    vec2 at = place / step_m;
    vec2 width = fwidth(at);
    vec2 near = abs(fract(at - 0.5) - 0.5) / max(width, vec2(1e-6));
    float fade = 1.0 - smoothstep(0.15, 0.6, max(width.x, width.y));
    return (1.0 - min(min(near.x, near.y), 1.0)) * fade;
  }

  void main() {
    float fog = 1.0 - smoothstep(0.25, 1.0, length(place - center.xy) / reach_m);
    float alpha = max(0.11 * line(cell_m), 0.26 * line(10.0 * cell_m)) * fog;
    if (alpha < 0.004) discard;
    gl_FragColor = vec4(ink, alpha);
  }
`;

export class Grid {
  readonly object: Mesh;
  cell_m = 0.1;
  private readonly material = new ShaderMaterial({
    vertexShader, fragmentShader, transparent: true, depthWrite: false, side: DoubleSide,
    uniforms: {
      cell_m: { value: 0.1 }, reach_m: { value: 10 }, center: { value: new Vector3() }, ink: { value: new Color("#888") } },
  });

  constructor() {
    this.object = new Mesh(new PlaneGeometry(1, 1), this.material);
    this.object.frustumCulled = false;
    this.object.renderOrder = -1;
  }

  setInk(color: string): void { (this.material.uniforms["ink"]?.value as Color).set(color); }

  // Adapts the grid to the camera: cells are decimetres, metres, ..., about a tenth of the picture.
  follow(eye: Vector3, target: Vector3, floor_m: number): void {
    const distance = eye.distanceTo(target);
    this.cell_m = 10 ** Math.floor(Math.log10(Math.max(distance / 4, 1e-4)));
    const reach_m = 12 * Math.max(distance, Math.abs(eye.z - floor_m));
    const { uniforms } = this.material;
    if (uniforms["cell_m"]) uniforms["cell_m"].value = this.cell_m;
    if (uniforms["reach_m"]) uniforms["reach_m"].value = reach_m / 2;
    (uniforms["center"]?.value as Vector3).set(target.x, target.y, floor_m);
    this.object.position.set(target.x, target.y, floor_m);
    this.object.scale.set(reach_m, reach_m, 1);
  }
}
