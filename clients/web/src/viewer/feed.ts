// Keeps the page in step with one world of the server: its watch, the links of its robots, its newest scans, and its past.
import type { PairRule, PlacedLink, Robot, RobotLinks, Scan, WatchWorldResponse, World } from "../world/stream";
import type { WorldObject } from "../world/types";
import { CallFailure, type RpcClient } from "./rpc_client";
import { backOff_ms, notFound, unavailable, unimplemented, type CallError, type Json } from "./messages";
import { CoalescedTask, withRetries } from "./retry";
import { rulesByPair, WorldModel, type WorldState } from "./world_model";

// A missing world may be created at any time, and so may further worlds.
const retryPeriod_ms = 1000;

// chosen: while running sensors make 30 revisions a second, the scans are listed less often, which are
// far rarer.
const scanPeriod_ms = 300;

// For lists in pages.
const pageSize = 1000;

export interface RobotModel { robot: Robot; links: readonly PlacedLink[]; }

export interface FeedListener {
  worlds: (worlds: readonly World[]) => void;
  watching: (world: string) => void;        // its watch begins
  state: (state: WorldState, received_ms: number) => void;  // the newest, and when it came by now_ms()
  observed: (objects: readonly string[]) => void;  // their last_observed changed
  robots: (robots: ReadonlyMap<string, RobotModel>) => void;
  scans: (scans: readonly Scan[]) => void;
  missing: (world: string) => void;         // the world does not exist (yet)
  failed: (error: CallError) => void;
}

export interface Past { state: WorldState; robots: Map<string, RobotModel>; }

// The server thins the revisions that running sensors make, and names the nearest one of which it has
// everything.
const nearestKept = (error: unknown): string | undefined =>
  error instanceof CallFailure && error.error.reason === "REVISION_COMPACTED" ? error.error.metadata?.["nearest_revision"] : undefined;

export class Feed {
  world: string | undefined;  // undefined: the first world
  readonly model = new WorldModel();
  private cancel: (() => void) | undefined;
  private timer = 0;
  private failures = 0;  // failures of the watch since its last message
  private isOpen = false;
  private shapes = new Map<string, readonly PlacedLink[]>();  // by the uids of the world and the robot
  private placed = new Map<string, RobotModel>();
  private readonly robots = new CoalescedTask(() => this.placeRobots());
  private readonly scans = new CoalescedTask(() => this.listScans(), scanPeriod_ms);

  constructor(private readonly client: RpcClient, private readonly listener: FeedListener) {}

  opened(): void {
    this.isOpen = true;
    void this.begin();
  }

  lost(): void {
    this.isOpen = false;
    this.stop();
  }

  choose(world: string): void {
    this.world = world;
    this.stop();
    this.placed.clear();
    void this.begin();
  }

  async refreshWorlds(): Promise<readonly World[]> {
    const { worlds } = await this.client.call<{ worlds: World[] }>("WorldService/ListWorlds", {});
    this.listener.worlds(worlds);
    return worlds;
  }

  // The world at a revision, or at the nearest one that is still kept. A server that is out of
  // resources is asked again while the answer is wanted.
  async at(revision: string, isWanted: () => boolean): Promise<Past> {
    const read = (at: string): Promise<Past> => withRetries(() => this.readRevision(at), () => this.isOpen && isWanted());
    try {
      return await read(revision);
    } catch (error) {
      const nearest = nearestKept(error);
      if (nearest === undefined || nearest === revision || !isWanted()) throw error;
      return read(nearest);
    }
  }

  private async readRevision(revision: string): Promise<Past> {
    const at_revision = { exact: revision };
    const world = this.world ?? "";  // even if another one is chosen meanwhile
    const { world_uid } = this.model.state;
    const objects = await this.pages<WorldObject>("WorldService/ListObjects", "objects", world, { at_revision, view: "OBJECT_VIEW_FULL" });
    const list = await this.pages<Robot>("RobotService/ListRobots", "robots", world, { at_revision });
    const { pair_rules } = await this.client.call<{ pair_rules: PairRule[] }>("WorldService/GetWorld", { world, at_revision });
    const robots = new Map<string, RobotModel>();
    for (const robot of list) {
      const { links } = await this.client.call<RobotLinks>("RobotService/GetRobotLinks", {
        world, name: robot.name, at_revision, with_shapes: true });
      robots.set(robot.name, { robot, links });
    }
    return { robots, state: {
      world_uid, revision, rules: rulesByPair(pair_rules),
      objects: new Map(objects.map((object) => [object.name, object])),
      robots: new Map(list.map((robot) => [robot.name, robot])) } };
  }

  async oldestRevision(): Promise<number> {
    const { world } = await this.client.call<{ world?: World }>("WorldService/GetWorld", { world: this.world ?? "" });
    return Number(world?.oldest_exact_revision ?? 0);
  }

  private async pages<Item>(method: "WorldService/ListObjects" | "RobotService/ListRobots", field: string,
                            world: string, request: Json): Promise<Item[]> {
    const all: Item[] = [];
    for (let page_token = ""; ;) {
      const page = await this.client.call<Json>(method, { world, page_size: pageSize, page_token, ...request });
      all.push(...(page[field] as Item[]));
      page_token = page["next_page_token"] as string;
      if (page_token === "") return all;
    }
  }

  private stop(): void {
    window.clearTimeout(this.timer);
    this.cancel?.();
    this.cancel = undefined;
  }

  private later(wait_ms = retryPeriod_ms): void {
    window.clearTimeout(this.timer);
    this.timer = window.setTimeout(() => { if (this.isOpen) void this.begin(); }, wait_ms);
  }

  private async begin(): Promise<void> {
    this.stop();
    try {
      const worlds = await this.refreshWorlds();
      this.world ??= (worlds.find(({ name }) => name === "default") ?? worlds[0])?.name;
      if (this.world === undefined || !worlds.some(({ name }) => name === this.world)) {
        this.listener.missing(this.world ?? "default");
        this.later();
        return;
      }
      this.watch(this.world);
    } catch (error) {
      if (error instanceof CallFailure) this.ended(error.error);
      else throw error;
    }
  }

  private watch(world: string): void {
    this.stop();
    this.listener.watching(world);
    this.model.restart();
    this.cancel = this.client.stream<WatchWorldResponse>("WorldService/WatchWorld",
      { world, mode: "WATCH_MODE_COALESCED", view: "OBJECT_VIEW_FULL" }, {
        message: (response, received_ms) => {
          this.failures = 0;
          const isChanged = this.model.apply(response);
          const observed = Object.keys(response.bookmark?.last_observed ?? {});
          if (observed.length > 0) {
            this.scans.request();  // a scan without changes makes no revision
            this.listener.observed(observed);
          }
          if (!isChanged) return;
          this.listener.state(this.model.state, received_ms);
          this.robots.request();
          this.scans.request();
        },
        end: (error) => {
          this.cancel = undefined;
          this.ended(error);
        },
      });
  }

  // A watch ends when the world is deleted or the server stops; either may come back.
  private ended(error: CallError | undefined): void {
    if (!this.isOpen) return;
    if (error && error.code !== notFound) this.listener.failed(error);
    this.later(Math.max(retryPeriod_ms, backOff_ms(this.failures++)));
  }

  private async placeRobots(): Promise<void> {
    const { robots } = this.model.state;
    let isChanged = false;
    for (const name of [...this.placed.keys()]) {
      if (!robots.has(name)) isChanged = this.placed.delete(name) || isChanged;
    }
    const present = new Set([...robots.values()].map((robot) => this.shapesKey(robot)));
    for (const key of [...this.shapes.keys()]) {
      if (!present.has(key)) this.shapes.delete(key);
    }
    for (const [name, robot] of robots) {
      if (this.placed.get(name)?.robot === robot) continue;
      const links = await this.linksOf(robot);
      if (!links) continue;
      this.placed.set(name, { robot, links });
      isChanged = true;
    }
    if (isChanged) this.listener.robots(new Map(this.placed));
  }

  private async linksOf(robot: Robot): Promise<readonly PlacedLink[] | undefined> {
    const key = this.shapesKey(robot);
    const shapes = this.shapes.get(key);
    try {
      const { links, robot_uid } = await this.callWithRetries<RobotLinks>("RobotService/GetRobotLinks", {
        world: this.world ?? "", name: robot.name, with_shapes: shapes === undefined });
      if (robot_uid !== robot.uid) return undefined;  // replaced meanwhile: its event follows
      if (shapes === undefined) this.shapes.set(key, links);
      return links.map((link, i) => ({ ...link, shapes: shapes?.[i]?.shapes ?? link.shapes }));
    } catch (error) {
      this.report(error);
      return undefined;
    }
  }

  private async listScans(): Promise<void> {
    const { world } = this;
    try {
      const { scans } = await this.callWithRetries<{ scans: Scan[] }>("PerceptionService/ListScans", { world: this.world ?? "" });
      if (this.world === world) this.listener.scans(scans);
    } catch (error) {
      this.report(error);
    }
  }

  private shapesKey(robot: Robot): string { return `${this.model.state.world_uid} ${robot.uid}`; }

  // Repeats the call if the server is temporarily out of resources, while connected to the same
  // world.
  private callWithRetries<Message>(method: "RobotService/GetRobotLinks" | "PerceptionService/ListScans", request: Json): Promise<Message> {
    const { world } = this;
    return withRetries(() => this.client.call<Message>(method, request), () => this.isOpen && this.world === world);
  }

  // Missing objects and lost connections are reported elsewhere.
  private report(error: unknown): void {
    if (!(error instanceof CallFailure)) throw error;
    const isOver = [notFound, unavailable, unimplemented].includes(error.error.code);
    if (this.isOpen && !isOver) this.listener.failed(error.error);
  }
}
