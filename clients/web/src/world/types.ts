// Messages of cwm.v1 as protobuf JSON: snake_case, 64-bit integers as strings, missing messages
// omitted. Metres, radians, world Z up; `x_a_b` is the pose of b in a.

export interface Vector2 { x: number; y: number; }
export interface Vector3 { x: number; y: number; z: number; }

export interface Pose {
  tx_m: number; ty_m: number; tz_m: number;
  qx: number; qy: number; qz: number; qw: number;
}

export interface Sphere { radius_m: number; }
export interface Box { size_x_m: number; size_y_m: number; size_z_m: number; }
export interface Cylinder { radius_m: number; length_m: number; }
export interface Cone { radius_bottom_m: number; radius_top_m: number; length_m: number; }
export interface Capsule { radius_m: number; length_m: number; }
export interface Polygon { vertices: Vector2[]; }
export interface Plate { outline: Polygon; holes: Polygon[]; thickness_m: number; }
export interface MeshByHash { hash: string; }

// An open vessel; its profiles are used only by grasp planners.
export interface Vessel {
  rim_radius_m: number;
  foot_radius_m: number;
  height_m: number;
  depth_m: number;
  wall_thickness_m: number;
  rim_radius_sigma_m?: number;
  wall_thickness_sigma_m?: number;
}

// Exactly one of them is set.
export interface ShapeOneOf {
  sphere?: Sphere;
  box?: Box;
  cylinder?: Cylinder;
  cone?: Cone;
  capsule?: Capsule;
  half_space?: Record<string, never>;
  plate?: Plate;
  convex?: MeshByHash;
  mesh?: MeshByHash;
}
export type ShapeKind = keyof ShapeOneOf;

export const shapeKinds: readonly ShapeKind[] = [
  "sphere", "box", "cylinder", "cone", "capsule", "half_space", "plate", "convex", "mesh"];

export function kindOf(shape: ShapeOneOf): ShapeKind | undefined {
  return shapeKinds.find((kind) => shape[kind] !== undefined);
}

export interface FitQuality {
  rms_m: number;
  max_residual_m: number;
  inlier_count: string;
  inlier_ratio: number;
  observed_fraction: number;
  parameter_sigma: number[];  // in the order of the coefficients; for a box, of its three sizes;
                              // empty: unknown
}

export interface ShapePart extends ShapeOneOf {
  x_object_shape?: Pose;  // absent: identity
  role: string;
  coefficients: number[];
  fit?: FitQuality;
  vessel?: Vessel;  // the vessel that the mesh represents
  hidden?: OrientedBox;  // space that no sensor saw, into which the part may extend
}

export interface SurfacePart {
  hash: string;
  vertex_count: string;
  triangle_count: string;
  watertight: boolean;
  point_count: string;
}

export interface OrientedBox { x_object_box: Pose; box: Box; }

export interface Handle {
  shape_index: number;
  point_count: string;
  axis: Vector3;
  bounds: OrientedBox;
  hash: string;  // empty: no mesh
}

// The link that holds an object.
export interface Attachment { robot: string; link: string; x_link_object?: Pose; touch_links: string[]; }

export interface WorldObject {
  name: string;
  uid: string;
  kind: string;
  owner: string;
  state: string;
  x_world_object?: Pose;  // missing if a user's object explains it
  shapes: ShapePart[];
  surfaces: SurfacePart[];
  handles: Handle[];
  supported_by: string;
  bounds?: OrientedBox;  // absent for an unbounded object
  point_count: string;
  create_revision: string;
  geometry_revision: string;
  pose_revision: string;
  last_observed?: string;
  margin_m: number;
  attached_to: string;
  reachable?: boolean;
  attachment?: Attachment;
  // The facts of running sensors about it; see SensorFacts.
  motion: string;
  visibility: string;
  identity_certain?: boolean;
  carried_by: string;
}

export interface IngestReport {
  points_in: string;
  points_finite: string;
  points_explained: string;
  points_rejected: string;
  warnings: string[];
}

export interface StageTime { stage: string; elapsed_ms: number; }

export interface IngestCloudResponse {
  world_uid: string;
  revision: string;
  x_world_sensor: Pose;
  report: IngestReport;
  supports: WorldObject[];
  objects: WorldObject[];
  stages: StageTime[];
}

// "support" for "OBJECT_KIND_SUPPORT" of the enum OBJECT_KIND.
export function shortName(value: string, type: string): string {
  return value.replace(`${type}_`, "").toLowerCase();
}

export const isCompleted = (part: ShapePart): boolean => part.role === "PART_ROLE_COMPLETED";
