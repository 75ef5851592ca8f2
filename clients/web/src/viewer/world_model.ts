// The newest state of a world, built from a watch's messages. Pure: no socket, no picture. States
// are values: unchanged objects are the same in the next state, so that readers compare by
// identity.
import type { PairRule, Robot, RobotEvent, ObjectEvent, SensorFacts, WatchWorldResponse } from "../world/stream";
import type { WorldObject } from "../world/types";

export interface WorldState {
  world_uid: string;
  revision: string;
  objects: ReadonlyMap<string, WorldObject>;
  robots: ReadonlyMap<string, Robot>;
  rules: ReadonlyMap<string, PairRule>;
}

export const emptyWorld: WorldState = {
  world_uid: "", revision: "0", objects: new Map(), robots: new Map(), rules: new Map() };

export function ruleKey({ pair: { a, b } }: PairRule): string {
  return JSON.stringify([[a.name, a.link], [b.name, b.link]].sort((x, y) => (String(x) < String(y) ? -1 : 1)));
}

const isUnchanged = (before: WorldObject | undefined, now: WorldObject): boolean =>
  before !== undefined && JSON.stringify(before) === JSON.stringify(now);

const hasFacts = (object: WorldObject, facts: SensorFacts): boolean =>
  object.motion === facts.motion && object.visibility === facts.visibility &&
  object.identity_certain === facts.identity_certain && object.carried_by === facts.carried_by;

function withFacts({ identity_certain: _before, ...rest }: WorldObject, facts: SensorFacts): WorldObject {
  return { ...rest, ...facts };
}

interface Changing {
  objects: Map<string, WorldObject>;
  robots: Map<string, Robot>;
  rules: Map<string, PairRule>;
}

function applyObject({ put, move, remove, pose_revision, motion }: ObjectEvent, objects: Map<string, WorldObject>): void {
  if (put) objects.set(put.name, put);
  if (remove !== undefined) objects.delete(remove);
  const moved = move ? objects.get(move.name) : undefined;
  if (!move || !moved) return;
  const { x_world_object: _before, ...rest } = moved;
  objects.set(move.name, { ...rest, pose_revision, motion, ...(move.x_world_object && { x_world_object: move.x_world_object }) });
}

function applyRobot({ put, state, remove }: RobotEvent, robots: Map<string, Robot>): void {
  if (put) robots.set(put.name, put);
  if (remove !== undefined) robots.delete(remove);
  const robot = state ? robots.get(state.name) : undefined;
  if (state && robot) robots.set(state.name, { ...robot, ...state });
}

// The rules by their pair, without empty ones.
export function rulesByPair(all: readonly PairRule[]): ReadonlyMap<string, PairRule> {
  const rules = new Map<string, PairRule>();
  for (const rule of all) applyRule(rule, rules);
  return rules;
}

function applyRule(rule: PairRule, rules: Map<string, PairRule>): void {
  if (rule.allowed || rule.check || rule.margin_m !== undefined) rules.set(ruleKey(rule), rule);
  else rules.delete(ruleKey(rule));
}

export class WorldModel {
  private state_: WorldState = emptyWorld;
  private pending: WatchWorldResponse[] = [];  // of the initial state or a revision, until complete

  get state(): WorldState { return this.state_; }

  // Called for a new watch: its initial state replaces the present state once it is complete.
  restart(): void { this.pending = []; }

  // True if the state has changed.
  apply(response: WatchWorldResponse): boolean {
    if (response.bookmark) return this.applyBookmark(response);
    this.pending.push(response);
    if (response.initial_state && !response.initial_state.initial_state_done) return false;
    if (response.events?.more) return false;
    const all = this.pending;
    this.pending = [];
    if (response.initial_state) this.begin(all, response);
    else this.change(all, response);
    return true;
  }

  // Unchanged objects keep their identity, so that a reconnection redraws only changes.
  private begin(all: readonly WatchWorldResponse[], { world_uid, revision }: WatchWorldResponse): void {
    const now: Changing = { objects: new Map(), robots: new Map(), rules: new Map() };
    for (const { initial_state } of all) {
      for (const object of initial_state?.objects ?? []) {
        const before = this.state_.objects.get(object.name);
        now.objects.set(object.name, before && isUnchanged(before, object) ? before : object);
      }
      for (const robot of initial_state?.robots ?? []) now.robots.set(robot.name, robot);
      for (const rule of initial_state?.pair_rules ?? []) applyRule(rule, now.rules);
    }
    const { rules } = this.state_;
    const isSame = JSON.stringify([...rules]) === JSON.stringify([...now.rules]);
    this.state_ = { world_uid, revision, ...now, rules: isSame ? rules : now.rules };
  }

  private change(all: readonly WatchWorldResponse[], { world_uid, revision }: WatchWorldResponse): void {
    const { objects, robots, rules } = this.state_;
    const areRuled = all.some(({ events }) => (events?.pair_rules.length ?? 0) > 0);
    const now: Changing = { objects: new Map(objects), robots: new Map(robots), rules: new Map(rules) };
    for (const { events } of all) {
      for (const event of events?.events ?? []) applyObject(event, now.objects);
      for (const event of events?.robot_events ?? []) applyRobot(event, now.robots);
      for (const rule of events?.pair_rules ?? []) applyRule(rule, now.rules);
    }
    this.state_ = { world_uid, revision, ...now, rules: areRuled ? now.rules : rules };
  }

  // Observation times change no geometry and make no revision; they are updated in place for the
  // details. Facts of sensors make no revision either, but the picture shows them.
  private applyBookmark({ revision, bookmark }: WatchWorldResponse): boolean {
    for (const [name, at] of Object.entries(bookmark?.last_observed ?? {})) {
      const object = this.state_.objects.get(name);
      if (object) object.last_observed = at;
    }
    const areNew = this.applyFacts(Object.entries(bookmark?.facts ?? {}));
    const isNewer = revision !== this.state_.revision && this.pending.length === 0;
    if (isNewer) this.state_ = { ...this.state_, revision };
    return isNewer || areNew;
  }

  private applyFacts(all: readonly (readonly [name: string, facts: SensorFacts])[]): boolean {
    const changed = all.flatMap(([name, facts]) => {
      const object = this.state_.objects.get(name);
      return object && !hasFacts(object, facts) ? [withFacts(object, facts)] : [];
    });
    if (changed.length === 0) return false;
    const objects = new Map(this.state_.objects);
    for (const object of changed) objects.set(object.name, object);
    this.state_ = { ...this.state_, objects };
    return true;
  }
}
