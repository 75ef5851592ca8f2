// The materials of the appearances, for shapes in batches.
import { DoubleSide, FrontSide, type Material, type MeshStandardMaterial } from "three";
import { completedMaterial, solidMaterial } from "../../scene/materials";

// "solid": measured or given. "completed": not measured, hatched. "unseen": space that no sensor
// has observed. "ghost": the body of a query. "mover": around something that moves and is not
// modelled. "stale": measured, and out of the sight of running sensors since.
export type Appearance = "solid" | "completed" | "unseen" | "ghost" | "mover" | "stale";

// A pattern of dots on the screen, through which objects behind stay visible.
const dots = `
  vec2 cell = fract(gl_FragCoord.xy / 9.0) - 0.5;
  gl_FragColor.a *= dot(cell, cell) < 0.03 ? 0.55 : 0.07;
`;

// Pale lines across the screen, on a surface that stays opaque; the legend has the same.
const lines = `
  gl_FragColor.rgb = mix(gl_FragColor.rgb, vec3(0.66), fract(gl_FragCoord.y / 4.0) < 0.5 ? 0.4 : 0.0);
`;

function patterned(material: MeshStandardMaterial, pattern: string, name: string): MeshStandardMaterial {
  material.transparent = true;
  material.depthWrite = false;
  return marked(material, pattern, name);
}

function marked(material: MeshStandardMaterial, pattern: string, name: string): MeshStandardMaterial {
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace(
      "#include <dithering_fragment>", `#include <dithering_fragment>\n${pattern}`);
  };
  material.customProgramCacheKey = () => name;
  return material;
}

// Boxes of a mover overlap: only the nearest one is drawn, so that the whole is evenly translucent.
function moverMaterial(): MeshStandardMaterial {
  const material = patterned(solidMaterial("#ffffff"), "gl_FragColor.a *= 0.42;", "mover");
  material.depthWrite = true;
  return material;
}

const materials: Record<Appearance, () => MeshStandardMaterial> = {
  solid: () => solidMaterial("#ffffff"),
  completed: () => completedMaterial("#ffffff"),
  unseen: () => patterned(solidMaterial("#ffffff"), dots, "unseen"),
  ghost: () => patterned(solidMaterial("#ffffff"), "gl_FragColor.a *= 0.55;", "ghost"),
  mover: moverMaterial,
  stale: () => marked(solidMaterial("#ffffff"), lines, "stale"),
};

export function materialFor(appearance: Appearance, isOpen: boolean): MeshStandardMaterial {
  const material = materials[appearance]();
  material.side = isOpen ? DoubleSide : FrontSide;
  return material;
}

// Shaders that shape round instances of a unit geometry by `form`. They run after the appearance's
// shader.
const forms = {
  // A cylinder of radius 1 and length 1: form is its radius at the bottom and at the top.
  shaft: {
    normal: "if (length(objectNormal.xy) > 0.5) objectNormal = normalize(vec3(objectNormal.xy, form.x - form.y));",
    place: "transformed.xy *= mix(form.x, form.y, transformed.z + 0.5);",
  },
  // A capsule of radius 1 and length 2: form.x is half its length, 0 for a sphere.
  capsule: { normal: "", place: "transformed.z += sign(transformed.z) * (form.x - 1.0);" },
};

export type Form = keyof typeof forms;

export function withForm(material: MeshStandardMaterial, form: Form): Material {
  const before = material.onBeforeCompile;
  const key = material.customProgramCacheKey();
  material.onBeforeCompile = (shader, renderer) => {
    before.call(material, shader, renderer);
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nattribute vec2 form;")
      .replace("#include <beginnormal_vertex>", `#include <beginnormal_vertex>\n${forms[form].normal}`)
      .replace("#include <begin_vertex>", `#include <begin_vertex>\n${forms[form].place}`);
  };
  material.customProgramCacheKey = () => `${key}-${form}`;
  return material;
}
