// Shading by depth alone, for points without normals: points behind their neighbours in the picture
// are darker. cited: Boucheny, "Interactive scientific visualization of large datasets: towards a
// perceptive-based approach" (2009), eye-dome lighting.
import {
  DepthTexture, HalfFloatType, Mesh, NoBlending, PlaneGeometry, Scene, ShaderMaterial, UnsignedIntType, Vector2,
  WebGLRenderTarget, type PerspectiveCamera, type WebGLRenderer,
} from "three";
import { FullScreenQuad } from "three/addons/postprocessing/Pass.js";

const multisampling = 4;

// tuned: by eye, on tables seen from a metre: how strongly a step in depth darkens, and the
// distance of the neighbours.
const strength = 55;
const reach_px = 1.5;
const darkest = 0.02;  // of steps, so that outlines stay grey

const vertexShader = `
  varying vec2 place;
  void main() { place = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }
`;

const fragmentShader = `
  uniform sampler2D colors;
  uniform sampler2D depths;
  uniform vec2 step_uv;
  uniform float near;
  uniform float far;
  varying vec2 place;

  // Negative for pixels without geometry.
  float logDistance(vec2 at) {
    float depth = texture2D(depths, at).x;
    if (depth >= 1.0) return -1.0;
    return log2(near * far / (far - depth * (far - near)) / near) + 1.0;
  }

  void main() {
    vec4 color = texture2D(colors, place);
    float here = logDistance(place);
    float behind = 0.0;
    if (here > 0.0) {
      for (int i = 0; i < 8; ++i) {
        float angle = 0.785398 * float(i);
        float there = logDistance(place + step_uv * vec2(cos(angle), sin(angle)));
        if (there > 0.0) behind += max(0.0, here - there) / 8.0;
      }
    }
    vec3 plain = color.a > 0.0 ? color.rgb / color.a : vec3(0.0);
    gl_FragColor = vec4(plain * exp(-${strength.toFixed(1)} * min(behind, ${darkest.toFixed(3)})), color.a);
    #include <colorspace_fragment>
    gl_FragColor.rgb *= gl_FragColor.a;  // as the page composes the canvas
  }
`;

// A part of the canvas, in CSS pixels from its lower left corner.
export interface Region { x: number; y: number; width: number; height: number; }

export class DepthShading {
  private readonly target = new WebGLRenderTarget(1, 1, {
    samples: multisampling, type: HalfFloatType, depthTexture: new DepthTexture(1, 1, UnsignedIntType) });
  private readonly material = new ShaderMaterial({
    vertexShader, fragmentShader, blending: NoBlending, depthTest: false, depthWrite: false,
    uniforms: {
      colors: { value: this.target.texture }, depths: { value: this.target.depthTexture },
      step_uv: { value: new Vector2() }, near: { value: 0 }, far: { value: 0 },
    },
  });
  private readonly quad = new FullScreenQuad(this.material);

  // Compiles the programs for the present scene without waiting for them, so that later drawing
  // does not wait.
  prepare(renderer: WebGLRenderer, scene: Scene, camera: PerspectiveCamera): void {
    renderer.setRenderTarget(this.target);  // programs differ by what they draw into
    renderer.compile(scene, camera);
    renderer.setRenderTarget(null);
    renderer.compile(new Scene().add(new Mesh(new PlaneGeometry(), this.material)), camera);
    renderer.getContext().flush();
  }

  // Smooths outlines, which costs the most where the processor draws. It is on at first.
  setSmooth(isSmooth: boolean): void {
    const samples = isSmooth ? multisampling : 0;
    if (this.target.samples === samples) return;
    this.target.samples = samples;
    this.target.dispose();  // made anew with the next picture
  }

  // Draws the scene; `drawn` is called before the shading itself adds to what the renderer counts.
  render(renderer: WebGLRenderer, scene: Scene, camera: PerspectiveCamera, region: Region, drawn: () => void): void {
    const ratio = renderer.getPixelRatio();
    const width = Math.max(1, Math.round(region.width * ratio));
    const height = Math.max(1, Math.round(region.height * ratio));
    this.target.setSize(width, height);
    renderer.setRenderTarget(this.target);
    renderer.clear();
    renderer.render(scene, camera);
    drawn();
    renderer.setRenderTarget(null);
    const { uniforms } = this.material;
    (uniforms["step_uv"]?.value as Vector2).set((reach_px * ratio) / width, (reach_px * ratio) / height);
    if (uniforms["near"]) uniforms["near"].value = camera.near;
    if (uniforms["far"]) uniforms["far"].value = camera.far;
    renderer.setViewport(region.x, region.y, region.width, region.height);
    renderer.setScissor(region.x, region.y, region.width, region.height);
    this.quad.render(renderer);
  }
}
