// The scan as the page holds it; clients/report/scan_page.cc writes it.
import type { IngestCloudResponse } from "../world/types";
import type { PackedMesh } from "../scene/mesh_geometry";

export type OwnerKind = "nobody" | "support" | "object";

// Consecutive points of the grid with the same label.
export interface PointRun {
  label: number;
  owner: OwnerKind;
  index: number;  // among the response's supports, or its objects
  part: number;   // of an object, from 1, shapes before handles; 0: the object itself
  count: number;
}

// In the sensor's frame: p = origin_m + step_m * (i, j, k).
export interface PackedPoints {
  measured: number;  // in the scan
  every: number;     // one of so many points is kept
  origin_m: [number, number, number];
  step_m: number;
  runs: PointRun[];
  grid: string;      // base64 of uint16 i j k, run by run
}

export interface ScanRecord {
  file: string;
  made: string;
  program: string;
  sensor_model: string;
  response: IngestCloudResponse;
  points: PackedPoints;
  meshes: Record<string, PackedMesh>;
}

export function readRecord(): ScanRecord {
  const element = document.getElementById("scan");
  return JSON.parse(element?.textContent ?? "") as ScanRecord;
}
