// Messages of a changing world as protobuf JSON: see world.proto, robot.proto, perception.proto.
import type { Pose, ShapePart, WorldObject } from "./types";

export interface World {
  name: string;
  world_uid: string;
  revision: string;
  object_count: string;
  oldest_exact_revision: string;
  robot_count: string;
}

export interface NamedThing { name: string; link: string; }

export interface PairRule {
  pair: { a: NamedThing; b: NamedThing };
  allowed: boolean;
  expires?: string;
  margin_m?: number;
  check?: boolean;  // two links of one robot are checked although its SRDF disables the pair
}

export interface RobotVariable { name: string; joint: string; joint_kind: string; lower?: number; upper?: number; }

// A state that the SRDF names.
export interface NamedState { name: string; values: { variable: string; value: number }[]; }

export interface RobotGroup { name: string; joints: string[]; states: NamedState[]; }

export interface Robot {
  name: string;
  uid: string;
  links: { name: string }[];
  variables: RobotVariable[];
  groups: RobotGroup[];
  x_world_base?: Pose;
  state: number[];
  state_revision: string;
}

// Exactly one of put, move, remove is set.
export interface ObjectEvent {
  put?: WorldObject;
  move?: { name: string; x_world_object?: Pose };
  remove?: string;
  pose_revision: string;
  motion: string;  // with move
}

// Exactly one of put, state, remove is set.
export interface RobotEvent {
  put?: Robot;
  state?: { name: string; x_world_base?: Pose; state: number[]; state_revision: string };
  remove?: string;
}

// The facts of running sensors about an object. It changes without a revision.
export interface SensorFacts {
  motion: string;
  visibility: string;
  identity_certain?: boolean;  // absent: followed by no sensor
  carried_by: string;
}

export interface WatchWorldResponse {
  world_uid: string;
  revision: string;
  initial_state?: {
    objects: WorldObject[];
    initial_state_done: boolean;
    robots: Robot[];
    pair_rules: PairRule[];
  };
  events?: { events: ObjectEvent[]; more: boolean; robot_events: RobotEvent[]; pair_rules: PairRule[] };
  bookmark?: { last_observed: Record<string, string>; facts: Record<string, SensorFacts> };
}

export interface PlacedLink { link: string; x_world_link?: Pose; shapes: ShapePart[]; }

export interface RobotLinks { revision: string; robot_uid: string; links: PlacedLink[]; }

// The poses of row i and link k are at i * links.length + k, each of 7 scalars: see `poseColumns`.
export interface LinkPoses { links: string[]; x_world_link: { scalar: string; data: string }; }

export interface Scan {
  sensor: string;
  revision: string;
  point_count: string;
  kept_count: string;
  points_hash: string;
  labels_hash: string;
  supports: string[];
  objects: string[];
}

export interface SensorMount { robot: string; link: string; }

export interface SensorPoseEstimate { translation_error_m: number; rotation_error_rad: number; surface_count: string; }

export interface Sensor {
  name: string;
  is_streaming: boolean;
  x_world_sensor?: Pose;
  mount?: SensorMount;
  last_frame?: string;
  frame_rate: number;
  latency_p50_ms: number;
  latency_p95_ms: number;
  processed_count: string;
  dropped_count: string;
  refused_count: string;
  estimate?: SensorPoseEstimate;
  conflicts: string[];
}

export interface PixelCounts {
  consistent: string;
  nearer: string;
  farther: string;
  missing: string;
  robot: string;
  carried: string;
  mixed: string;
  hidden: string;
}

// The points of a sensor's frame. The bytes are views of the message's buffer, not aligned.
export interface SensorPoints {
  sensor: string;
  frame_stamp?: string;
  points: Uint8Array;   // x y z of each point, 3 x f32, in the world's frame
  classes: Uint8Array;  // one PixelClass per point
  pixels?: PixelCounts;
  latency_ms: number;   // last byte of the frame to its answer
}
