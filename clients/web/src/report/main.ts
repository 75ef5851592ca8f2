// The page: reads the scan that it carries, builds the pictures and the tables.
import { Box3, Vector3 } from "three";
import { meshSource } from "../scene/mesh_geometry";
import type { MeshSource } from "../scene/shape_geometry";
import { describe, publish } from "./drawn";
import { element } from "../page/dom";
import { heading, keyFigures, stageBars, warnings } from "./figures";
import { Gallery } from "./gallery";
import { Highlight } from "./highlight";
import { legend } from "./legend";
import { objectTable } from "./object_table";
import { buildPictures } from "./pictures";
import { readRecord, type ScanRecord } from "./record";
import { scanObjectsOf, type ScanObject } from "./scan_objects";

const pointSize_px = 1.6;

// The bounds of the first view: the objects, otherwise everything with bounds, otherwise a metre
// around the origin.
function interest(scanObjects: readonly ScanObject[]): Box3 {
  const bounds = new Box3();
  const add = (of: readonly ScanObject[]): void => { for (const scanObject of of) bounds.union(scanObject.bounds); };
  add(scanObjects.filter((scanObject) => scanObject.kind === "object"));
  if (bounds.isEmpty()) add(scanObjects);
  return bounds.isEmpty() ? bounds.setFromCenterAndSize(new Vector3(), new Vector3(1, 1, 1)) : bounds;
}

function gallery(record: ScanRecord, scanObjects: readonly ScanObject[], meshes: MeshSource,
                 highlight: Highlight): Gallery | undefined {
  try {
    const made = new Gallery(buildPictures({ record, scanObjects, meshes, pointSize_px }), scanObjects, highlight);
    const { tx_m, ty_m, tz_m } = record.response.x_world_sensor;
    made.look(interest(scanObjects), new Vector3(tx_m, ty_m, tz_m));
    return made;
  } catch (error) {
    console.error(error);
    return undefined;
  }
}

function build(): void {
  const record = readRecord();
  const meshes = meshSource(record.meshes);
  const scanObjects = scanObjectsOf(record, meshes);
  const highlight = new Highlight();
  const pictures = gallery(record, scanObjects, meshes, highlight);
  const page = document.getElementById("page") as HTMLElement;
  page.append(heading(record), keyFigures(record, scanObjects));
  const notes = warnings(record, scanObjects);
  if (notes) page.append(notes);
  if (pictures) page.append(pictures.root, legend(() => pictures.orbit.home()));
  else page.append(element("p", "missing", "The pictures need WebGL 2, which this browser does not offer here."));
  page.append(element("h2", "", "Objects and coefficients"), objectTable(scanObjects, highlight),
    element("p", "note", "Coefficients are in the object's frame and in PCL's order, ± one standard deviation."),
    element("h2", "", "Time of each stage"), stageBars(record.response.stages));
  window.addEventListener("keydown", (event) => { if (event.key === "Escape") highlight.pick(highlight.pinned); });
  if (!pictures) return;
  pictures.render();
  publish(describe(pictures, scanObjects));
}

build();
