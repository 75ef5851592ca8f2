// A description of what three.js has rendered, for tests. It is measured on the vertices, not
// copied from the record.
import { Box3, BufferGeometry, Group, Matrix4, Mesh, Points, type Object3D, Vector3 } from "three";
import type { Drawn } from "../scene/object_model";
import type { Gallery } from "./gallery";
import type { ScanObject } from "./scan_objects";

const triple = (v: Vector3): number[] => [v.x, v.y, v.z];

// Bounds in the geometry's own frame, and the widest and narrowest circles around z that its lowest and
// highest vertices lie on: a cone's two radii.
function measure(geometry: BufferGeometry): object {
  const position = geometry.getAttribute("position");
  const bounds = new Box3();
  const vertex = new Vector3();
  let widest = 0;
  for (let i = 0; i < position.count; ++i) {
    vertex.fromBufferAttribute(position, i);
    bounds.expandByPoint(vertex);
    widest = Math.max(widest, Math.hypot(vertex.x, vertex.y));
  }
  const radiusAt = (z: number): number => {
    let radius = 0;
    for (let i = 0; i < position.count; ++i) {
      vertex.fromBufferAttribute(position, i);
      if (Math.abs(vertex.z - z) < 1e-6) radius = Math.max(radius, Math.hypot(vertex.x, vertex.y));
    }
    return radius;
  };
  return {
    low: triple(bounds.min), high: triple(bounds.max), widest,
    radius_low: radiusAt(bounds.min.z), radius_high: radiusAt(bounds.max.z),
    vertices: position.count, triangles: (geometry.index?.count ?? position.count) / 3,
  };
}

// Row by row.
const rows = (matrix: Matrix4): number[] => matrix.clone().transpose().elements;

function objectIndexOf(node: Object3D): unknown {
  for (let at: Object3D | null = node; at; at = at.parent) {
    if (at instanceof Group && typeof at.userData["objectIndex"] === "number") return at.userData["objectIndex"];
  }
  return undefined;
}

function transparencyOf(mesh: Mesh): boolean[] {
  return [mesh.material].flat().map((material) => material.transparent);
}

function listDrawn(root: Object3D, scanObjects: readonly ScanObject[]): { points: object[]; parts: object[] } {
  const points: object[] = [];
  const parts: object[] = [];
  root.traverse((node) => {
    const index = objectIndexOf(node);
    const object = typeof index === "number" ? scanObjects[index]?.object.name ?? "" : "";
    if (node instanceof Points) {
      points.push({ object, label: node.userData["run"].label, count: node.geometry.getAttribute("position").count });
    } else if (node instanceof Mesh && node.userData["drawn"]) {
      parts.push({ object, ...(node.userData["drawn"] as Drawn), ...measure(node.geometry),
                   transparent: transparencyOf(node), x_world: rows(node.matrixWorld) });
    }
  });
  return { points, parts };
}

export function describe(gallery: Gallery, scanObjects: readonly ScanObject[]): object {
  return {
    device_pixel_ratio: window.devicePixelRatio,
    pictures: gallery.panes.map(({ picture, view, calls, triangles, points }) => {
      const rect = view.getBoundingClientRect();
      return {
        name: picture.name, left: rect.left, top: rect.top, width: rect.width, height: rect.height,
        rendered: { calls, triangles, points }, ...listDrawn(picture.scene, scanObjects),
      };
    }),
  };
}

export function publish(drawn: object): void {
  const script = document.createElement("script");
  script.type = "application/json";
  script.id = "drawn";
  script.textContent = JSON.stringify(drawn);
  document.body.append(script);
}
