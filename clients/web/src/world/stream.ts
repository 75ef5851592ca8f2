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
}

// Exactly one of put, state, remove is set.
export interface RobotEvent {
  put?: Robot;
  state?: { name: string; x_world_base?: Pose; state: number[]; state_revision: string };
  remove?: string;
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
  bookmark?: { last_observed: Record<string, string> };
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
