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
import { thingsOf, type Thing } from "./things";

const pointSize_px = 1.6;

// The bounds of the first view: the objects, otherwise everything with bounds, otherwise a metre
// around the origin.
function interest(things: readonly Thing[]): Box3 {
  const bounds = new Box3();
  const add = (of: readonly Thing[]): void => { for (const thing of of) bounds.union(thing.bounds); };
  add(things.filter((thing) => thing.kind === "object"));
  if (bounds.isEmpty()) add(things);
  return bounds.isEmpty() ? bounds.setFromCenterAndSize(new Vector3(), new Vector3(1, 1, 1)) : bounds;
}

function gallery(record: ScanRecord, things: readonly Thing[], meshes: MeshSource,
                 highlight: Highlight): Gallery | undefined {
  try {
    const made = new Gallery(buildPictures({ record, things, meshes, pointSize_px }), things, highlight);
    const { tx_m, ty_m, tz_m } = record.response.x_world_sensor;
    made.look(interest(things), new Vector3(tx_m, ty_m, tz_m));
    return made;
  } catch (error) {
    console.error(error);
    return undefined;
  }
}

function build(): void {
  const record = readRecord();
  const meshes = meshSource(record.meshes);
  const things = thingsOf(record, meshes);
  const highlight = new Highlight();
  const pictures = gallery(record, things, meshes, highlight);
  const page = document.getElementById("page") as HTMLElement;
  page.append(heading(record), keyFigures(record, things));
  const notes = warnings(record, things);
  if (notes) page.append(notes);
  if (pictures) page.append(pictures.root, legend(() => pictures.orbit.home()));
  else page.append(element("p", "missing", "The pictures need WebGL 2, which this browser does not offer here."));
  page.append(element("h2", "", "Objects and coefficients"), objectTable(things, highlight),
    element("p", "note", "Coefficients are in the object's frame and in PCL's order, ± one standard deviation."),
    element("h2", "", "Time of each stage"), stageBars(record.response.stages));
  window.addEventListener("keydown", (event) => { if (event.key === "Escape") highlight.pick(highlight.pinned); });
  if (!pictures) return;
  pictures.render();
  publish(describe(pictures, things));
}

build();
