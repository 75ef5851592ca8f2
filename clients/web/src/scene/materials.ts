// The materials of parts: measured parts are solid, completed parts are hatched and translucent.
import {
  DoubleSide, FrontSide, LineBasicMaterial, MeshStandardMaterial, PointsMaterial,
  type ColorRepresentation,
} from "three";

const roughness = 0.75;  // no glare that could be taken for an edge

export function solidMaterial(color: ColorRepresentation): MeshStandardMaterial {
  return new MeshStandardMaterial({
    color, roughness, side: FrontSide,
    polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,  // edges lie on top
  });
}

// Open meshes are drawn from both sides.
export function surfaceMaterial(color: ColorRepresentation): MeshStandardMaterial {
  const material = solidMaterial(color);
  material.side = DoubleSide;
  return material;
}

// Diagonal stripes in screen space, six device pixels apart; the legend has the same.
const hatch = `
  float stripe = fract((gl_FragCoord.x + gl_FragCoord.y) / 6.0);
  gl_FragColor.a *= stripe < 0.34 ? 0.85 : 0.16;
`;

export function completedMaterial(color: ColorRepresentation): MeshStandardMaterial {
  const material = solidMaterial(color);
  material.transparent = true;
  material.depthWrite = false;
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace(
      "#include <dithering_fragment>", `#include <dithering_fragment>\n${hatch}`);
  };
  material.customProgramCacheKey = () => "completed";
  return material;
}

export function edgeMaterial(color: ColorRepresentation, opacity: number): LineBasicMaterial {
  return new LineBasicMaterial({ color, transparent: true, opacity });
}

export function pointMaterial(color: ColorRepresentation, size_px: number): PointsMaterial {
  return new PointsMaterial({ color, size: size_px, sizeAttenuation: false });
}
