// The page: its selections, and the parts that follow them.
import { element } from "../page/dom";
import type { LinkPoses, Scan, World } from "../world/stream";
import { parseResult, type QueryResult, type Reply } from "./query_result";
import { ghostRequest, ghostsOf, type RobotGhosts } from "./robot_ghosts";
import { Picture } from "./draw/picture";
import { Feed, type RobotModel } from "./feed";
import { GraspController } from "./grasp_controller";
import { SensorController } from "./sensor_controller";
import { publish } from "./hooks";
import { CallFailure, type RpcClient } from "./rpc_client";
import type { ConnectionState } from "./messages";
import { CoalescedTask, LatestRequest } from "./retry";
import { Details } from "./panels/details";
import { helpDialog } from "./panels/help";
import { QueryPanel } from "./panels/query_panel";
import { Timeline } from "./panels/timeline";
import { Toolbar } from "./panels/toolbar";
import { Tree } from "./panels/tree";
import type { Query } from "./query";
import { styleColor, ThemeSwitch } from "./theme";
import { centreOf, SceneObjectList, type Kind, type SceneObject } from "./scene_objects";
import { emptyWorld, type WorldState } from "./world_model";

interface Snapshot { state: WorldState; robots: ReadonlyMap<string, RobotModel>; }

const pointSizes_px = [1, 2, 3, 5];
const noticeTime_ms = 6000;

// chosen: how often the oldest kept revision is asked for, while running sensors make 30 a second.
const rangePeriod_ms = 500;

// Below the panels at the bottom of the picture, as in style.css.
const bottomGap_px = 14;

export class Page {
  private readonly sceneObjects = new SceneObjectList();
  private readonly picture = new Picture((name) => this.sceneObjects.byName.get(name)?.color, (why) => this.notice(why));
  private readonly grasps = new GraspController(this.picture, (object) => this.select(this.sceneObjects.byName.has(object) ? object : undefined));
  private readonly sensors: SensorController;
  private readonly theme = new ThemeSwitch(() => this.showTheme());
  private readonly feed: Feed;
  private readonly toolbar: Toolbar;
  private readonly tree: Tree;
  private readonly details: Details;
  private readonly queryPanel: QueryPanel;
  private readonly timeline: Timeline;
  private readonly help = helpDialog();
  private readonly empty = element("p", "empty");
  private readonly scale = element("p", "scale");
  private readonly notices = element("div", "notices");
  private live: Snapshot = { state: emptyWorld, robots: new Map() };
  private missing: string | undefined;  // the wanted world, while the server has none of its name
  private past: Snapshot | undefined;  // displayed instead of the live state
  private wantedRevision: number | undefined;
  private isGoing = false;
  private readonly pendingQuery = new LatestRequest();
  private selected: string | undefined;
  private readonly hiddenNames = new Set<string>();
  private readonly hiddenKinds = new Set<Kind>();
  private scanIsWanted = true;
  private pointSize = 1;
  private firstPicture_ms = 0;
  private updates = 0;
  private lastUpdate_ms = 0;  // Date.now() when the newest state was drawn
  private isDrawnUpToDate = true;

  constructor(body: HTMLElement, private readonly client: RpcClient) {
    this.tree = new Tree({
      select: (name) => this.selectInList(name), frame: (name) => this.picture.frame([name]),
      toggle: (name) => this.toggle(this.hiddenNames, name), toggleKind: (kind) => this.toggle(this.hiddenKinds, kind) });
    this.details = new Details({ close: () => this.select(undefined), frame: (name) => this.picture.frame([name]) });
    this.queryPanel = new QueryPanel({
      centreOf: (name) => centreOf(this.sceneObjects.byName.get(name)), robot: (name) => this.seen.state.robots.get(name) }, {
      evaluate: (query) => void this.evaluate(query), clear: () => this.dropQuery(), select: (name) => this.select(name) });
    this.timeline = new Timeline({ go: (revision) => void this.go(revision), live: () => this.goLive() });
    this.toolbar = new Toolbar((world) => this.choose(world), () => { this.feed.refreshWorlds().catch(() => undefined); });
    this.sensors = new SensorController(client, this.picture, () => this.showClouds(), (why) => this.notice(why));
    this.addTools();
    this.layOut(body);
    this.client.onState = (state) => this.onConnection(state);
    this.feed = new Feed(this.client, {
      worlds: (worlds) => this.showWorlds(worlds), watching: (world) => this.sensors.follow(world), state: (state, received_ms) => this.onState(state, received_ms), robots: (robots) => this.onRobots(robots),
      observed: (names) => this.onObserved(names), scans: (scans) => this.onScans(scans), missing: (world) => this.onMissing(world),
      failed: ({ name, message }) => this.notice(`${name}: ${message}`) });
    this.feed.world = new URLSearchParams(window.location.search).get("world") || undefined;
    this.listen();
    this.showTheme();
    publish({ stage: this.picture.stage, view: this.picture.view, sceneObjects: () => this.sceneObjects.byName.values(),
              isShown: (sceneObject) => this.isShown(sceneObject), facts: () => this.facts() });
  }

  private get seen(): Snapshot { return this.past ?? this.live; }

  private layOut(body: HTMLElement): void {
    const left = element("aside", "side left", this.tree.root, this.sensors.panel.root, this.grasps.panel.root, this.grasps.opener.input);
    left.setAttribute("aria-label", "Objects");
    const right = element("aside", "side right", this.details.root);
    const menu = element("button", "menu", "\u2630");
    menu.setAttribute("aria-label", "Show or hide the list of objects");
    menu.addEventListener("click", () => body.classList.toggle("listing"));
    this.toolbar.root.prepend(menu);
    const bottom = element("div", "bottom", this.queryPanel.result, this.queryPanel.root, this.timeline.root);
    const middle = element("main", "middle", this.picture.stage.root, this.empty, this.scale, this.notices, bottom);
    new ResizeObserver(() => {
      this.picture.stage.labels.covered_px = bottom.offsetHeight + bottomGap_px;
      this.picture.stage.requestRender();
    }).observe(bottom);
    this.notices.setAttribute("role", "alert");
    this.empty.hidden = true;
    body.append(this.toolbar.root, left, middle, right, this.help);
  }

  private addTools(): void {
    const { picture, toolbar } = this;
    toolbar.addSwitch({ key: "n", title: "Names", label: "Names", isOn: false, turn: (isOn) => {
      picture.shown.names = isOn;
      picture.refresh();
    } });
    toolbar.addSwitch({ key: "x", title: "Frames of objects", label: "Frames", isOn: false, turn: (isOn) => {
      picture.shown.frames = isOn;
      picture.refresh();
    } });
    toolbar.addSwitch({ key: "p", title: "Points of the newest scans", label: "Scan", isOn: true, turn: (isOn) => {
      this.scanIsWanted = isOn;
      this.showClouds();
    } });
    toolbar.addSwitch({ key: "m", title: "Shapes, surfaces and handles", label: "Model", isOn: true, turn: (isOn) => {
      picture.hideLayers(new Set(isOn ? [] : ["shapes", "surfaces", "handles"] as const));
    } });
    toolbar.addSwitch({ key: "k", title: "Grippers of the grasps that were opened", label: "Grasps", isOn: true,
                        turn: (isOn) => this.grasps.turn(isOn) });
    toolbar.addAction({ key: "o", title: "Open grasps that cwm-grasp --json wrote, or drop the file on the page", label: "Open",
                        run: () => this.grasps.opener.openDialog() });
    toolbar.addAction({ key: "f", title: "Everything, or the selection", label: "Frame", run: () => this.frame() });
    toolbar.addAction({ key: "g", title: "Save the picture", label: "Save", run: () => void this.save() });
    toolbar.addAction({ key: "t", title: "Light or dark", label: "Theme", run: () => this.theme.toggle() });
    toolbar.addAction({ key: "?", title: "Keys and questions", label: "Help", run: () => this.help.showModal() });
  }

  private listen(): void {
    this.picture.stage.onClick((event) => {
      const picked = this.picture.pick(event);
      if (typeof picked === "object") this.grasps.choose(picked);
      else this.select(picked);
    });
    this.picture.stage.onFrame = () => this.onFrame();
    this.picture.stage.onFinished = () => this.sensors.drawn();
    window.addEventListener("keydown", (event) => this.onKey(event));
  }

  private onConnection(state: ConnectionState): void {
    this.toolbar.showConnection(state);
    if (state.is === "open") this.feed.opened();
    else if (state.is !== "connecting") this.lost();
    if (state.is === "refused") {
      this.notice(`The server refuses this page. ${state.why}`, Infinity);
    }
  }

  private lost(): void {
    this.feed.lost();
    this.sensors.follow(undefined);
  }

  private onState(state: WorldState, received_ms: number): void {
    const isOther = state.world_uid !== this.live.state.world_uid;
    this.sensors.stateReceived(received_ms);
    this.live = { ...this.live, state };
    this.missing = undefined;
    ++this.updates;
    this.isDrawnUpToDate = false;
    if (isOther && this.past) this.timeline.goLive();
    this.forgetHidden();
    if (isOther && this.picture.view.instanceCount === 0) this.picture.reset();
    this.showRange();
    if (!this.past) this.show();
    this.picture.stage.begin();
  }

  // Observation times are updated in place.
  private onObserved(names: readonly string[]): void {
    if (!this.past && this.selected !== undefined && names.includes(this.selected)) this.details.refresh();
  }

  private onRobots(robots: ReadonlyMap<string, RobotModel>): void {
    this.live = { ...this.live, robots };
    if (!this.past) this.show();
  }

  // Live points take the place of the scans that were interpreted; neither belongs to the past.
  private showClouds(): void {
    this.picture.clouds.root.visible = this.scanIsWanted && !this.past && !this.sensors.areShown;
    this.picture.refresh();
  }

  private onScans(scans: readonly Scan[]): void {
    this.picture.setScans(scans);  // hidden while the past is displayed
  }

  private onMissing(world: string): void {
    this.missing = world;
    this.sensors.follow(undefined);
    this.picture.stage.begin();
    if (this.live.state.objects.size > 0 || this.live.robots.size > 0) {
      this.live = { state: emptyWorld, robots: new Map() };
      this.picture.setScans([]);
    }
    this.show();
  }

  private showWorlds(worlds: readonly World[]): void { this.toolbar.showWorlds(worlds, this.feed.world); }

  private choose(world: string): void {
    this.timeline.goLive();
    this.missing = undefined;
    this.select(undefined);
    this.queryPanel.clear();
    this.live = { state: emptyWorld, robots: new Map() };
    this.forgetHidden();
    this.show();
    this.picture.setScans([]);
    this.picture.reset();
    this.feed.choose(world);
    const url = new URL(window.location.href);
    url.searchParams.set("world", world);
    window.history.replaceState(null, "", url);
  }

  // A world without objects and robots would be a blank page.
  private showEmptiness({ world_uid, revision, objects, robots }: WorldState): void {
    const isMissing = this.missing !== undefined && !this.past;
    const isEmpty = world_uid !== "" && objects.size === 0 && robots.size === 0;
    this.empty.hidden = !isMissing && !isEmpty;
    const text = isMissing
      ? `There is no world \u201c${this.missing}\u201d yet. It appears here as soon as somebody puts an object into it.`
      : `The world \u201c${this.feed.world ?? ""}\u201d is empty at revision ${revision}. What is scanned or put into it appears here.`;
    if (this.empty.textContent !== text) this.empty.textContent = text;
  }

  // Updates panels and picture to the displayed state.
  private show(): void {
    const { state, robots } = this.seen;
    this.showEmptiness(state);
    this.sceneObjects.update(state, robots);
    if (this.selected !== undefined && !this.sceneObjects.byName.has(this.selected)) this.select(undefined);
    this.tree.show(this.sceneObjects.byName);
    this.showSelection();
    this.showShown();
    this.picture.clouds.recolor();
    this.grasps.follow(state);
  }

  // A removed object is no longer hidden, so that a new object of its name is visible.
  private forgetHidden(): void {
    const { objects, robots } = this.live.state;
    const gone = [...this.hiddenNames].filter((name) => !objects.has(name) && !robots.has(name));
    for (const name of gone) this.hiddenNames.delete(name);
    if (gone.length > 0) this.tree.setHidden(this.hiddenNames, this.hiddenKinds);
  }

  private isShown({ name, kind }: SceneObject): boolean { return !this.hiddenNames.has(name) && !this.hiddenKinds.has(kind); }

  private showShown(): void {
    this.picture.setObjects([...this.sceneObjects.byName.values()].filter((sceneObject) => this.isShown(sceneObject)));
  }

  private toggle<Value>(set: Set<Value>, value: Value): void {
    if (!set.delete(value)) set.add(value);
    this.tree.setHidden(this.hiddenNames, this.hiddenKinds);
    this.showShown();
  }

  private select(name: string | undefined): void {
    this.selected = name;
    this.tree.select(name);
    this.grasps.selected(name);
    document.body.classList.toggle("detailing", name !== undefined);
    this.showSelection();
  }

  // In a narrow window the list covers the details.
  private selectInList(name: string): void {
    document.body.classList.remove("listing");
    this.select(name);
  }

  private showSelection(): void {
    const sceneObject = this.selected === undefined ? undefined : this.sceneObjects.byName.get(this.selected);
    this.details.show(sceneObject, this.seen.state.rules);
    this.picture.setSelected(sceneObject);
  }

  private frame(view?: string): void {
    this.picture.frame(this.selected === undefined || view !== undefined ? undefined : [this.selected], view);
  }

  private readonly range = new CoalescedTask(() => this.readRange(), rangePeriod_ms);
  private showRange(): void {
    this.timeline.setNewest(Number(this.live.state.revision));
    this.range.request();
  }

  private async readRange(): Promise<void> {
    try {
      this.timeline.setOldest(await this.feed.oldestRevision());
    } catch (error) {
      if (!(error instanceof CallFailure)) throw error;
      this.timeline.setOldest(Number(this.live.state.revision));
    }
  }

  // Goes to the revision requested last, one at a time.
  private async go(revision: number): Promise<void> {
    this.wantedRevision = revision;
    if (this.isGoing) return;
    this.isGoing = true;
    try {
      for (let at = -1; this.wantedRevision !== undefined && this.wantedRevision !== at;) {
        at = this.wantedRevision;
        const seen = await this.readRevision(at);
        if (!seen) continue;
        if (this.wantedRevision === undefined || seen.state.world_uid !== this.live.state.world_uid) break;
        this.past = seen;
        const kept = Number(seen.state.revision);  // the nearest one
        if (this.wantedRevision === at && kept !== at) {
          at = this.wantedRevision = kept;
          this.timeline.showPast(kept);
        }
        this.sensors.showPast(true);
        this.showClouds();  // none: the scans of that time are no longer kept
        this.show();
      }
    } catch (error) {
      if (!(error instanceof CallFailure)) throw error;
      this.notice(error.message);
      this.timeline.goLive();
    } finally {
      this.isGoing = false;
    }
  }

  // Undefined if another revision is wanted by the time it fails.
  private async readRevision(revision: number): Promise<Snapshot | undefined> {
    const isWanted = (): boolean => this.wantedRevision === revision;
    try {
      return await this.feed.at(String(revision), isWanted);
    } catch (error) {
      if (isWanted()) throw error;
      return undefined;
    }
  }

  private goLive(): void {
    this.wantedRevision = undefined;
    if (!this.past) return;
    this.past = undefined;
    this.sensors.showPast(false);
    this.showClouds();
    this.show();
  }

  private async evaluate(query: Query): Promise<void> {
    const { request, method } = query;
    const options = { ...(request["options"] as object), ...(this.past && { at_revision: { exact: this.past.state.revision } }) };
    const isWanted = this.pendingQuery.begin();
    this.picture.setPendingQuery(query);
    try {
      const reply = await this.client.call<Reply>(method, { ...request, world: this.feed.world ?? "", options });
      if (!isWanted()) return;
      const result = parseResult(query, reply);
      const ghosts = await this.ghosts(query, result, reply.revision);
      if (!isWanted()) return;
      this.picture.setResult(query, result, ghosts);
      this.queryPanel.showResult(query.kind, result, reply.revision);
    } catch (error) {
      if (!(error instanceof CallFailure)) throw error;
      if (isWanted()) this.queryPanel.showError(error.error);
    }
  }

  // Where the query places a robot.
  private async ghosts(query: Query, result: QueryResult, revision: string): Promise<RobotGhosts> {
    const robot = this.seen.state.robots.get(query.robot?.name ?? "");
    const request = ghostRequest(query, result, robot, revision);
    if (!request) return [];
    return ghostsOf(await this.client.call<LinkPoses>("RobotService/GetLinkPoses", { ...request, world: this.feed.world ?? "" }));
  }

  private dropQuery(): void {
    this.pendingQuery.drop();
    this.picture.clearResult();
  }

  private async save(): Promise<void> {
    try {
      const blob = await this.picture.stage.screenshot(styleColor("--picture"));
      const anchor = element("a");
      anchor.href = URL.createObjectURL(blob);
      anchor.download = `${this.feed.world ?? "world"}-${this.seen.state.revision}.png`;
      anchor.click();
      URL.revokeObjectURL(anchor.href);
    } catch (error) {
      this.notice(String(error));
    }
  }

  private notice(text: string, time_ms = noticeTime_ms): void {
    if ([...this.notices.children].some((child) => child.textContent === text)) return;
    const notice = element("p", "notice", text);
    this.notices.append(notice);
    if (Number.isFinite(time_ms)) window.setTimeout(() => notice.remove(), time_ms);
  }

  private showTheme(): void {
    this.picture.stage.grid.setInk(styleColor("--grid"));
    this.picture.setSelectionColor(styleColor("--accent"));
  }

  private onFrame(): void {
    const { grid, figures } = this.picture.stage;
    const cell_m = grid.cell_m;
    const text = `grid ${cell_m >= 1 ? `${cell_m} m` : cell_m >= 0.01 ? `${Math.round(100 * cell_m)} cm` : `${Math.round(1000 * cell_m)} mm`}`;
    if (this.scale.textContent !== text) this.scale.textContent = text;
    if (this.firstPicture_ms === 0 && this.updates > 0) this.firstPicture_ms = performance.now();
    if (!this.isDrawnUpToDate && figures.frames > 0) this.lastUpdate_ms = Date.now();
    this.isDrawnUpToDate = true;
    this.sensors.issued();
  }

  private facts(): Record<string, unknown> {
    const { state } = this.seen;
    return { world: this.feed.world ?? "", world_uid: state.world_uid, revision: state.revision, updates: this.updates,
             first_picture_ms: this.firstPicture_ms, last_update_ms: this.lastUpdate_ms,
             cloud_points: this.picture.clouds.pointCount, is_live: this.past === undefined,
             selected: this.selected ?? "", theme: this.theme.now, ...this.grasps.facts(),
             ...this.sensors.facts() };
  }

  private changePointSize(): void {
    this.pointSize = (this.pointSize + 1) % pointSizes_px.length;
    for (const cloud of [this.picture.clouds, this.picture.livePoints]) cloud.setSize(pointSizes_px[this.pointSize] ?? 2);
    this.picture.refresh();
  }

  private escape(): void {
    if (this.queryPanel.hasResult || this.pendingQuery.isPending) this.queryPanel.clear();
    else this.select(undefined);
    document.body.classList.remove("listing");
    this.picture.stage.root.focus();
  }

  private onKey(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey || this.help.open) return;
    if (event.key === "Escape") {
      this.escape();
      return;
    }
    const typing = event.target instanceof HTMLInputElement && ["text", "search"].includes(event.target.type);
    if (typing || event.target instanceof HTMLSelectElement) return;
    const keys: Record<string, () => void> = {
      f: () => this.frame(), "/": () => this.tree.search.focus(), q: () => this.queryPanel.input.focus(), l: () => this.timeline.goLive(),
      t: () => this.theme.toggle(), g: () => void this.save(), o: () => this.grasps.opener.openDialog(),
      "?": () => this.help.showModal(), s: () => this.changePointSize(), v: () => this.sensors.toggle(),
      h: () => { if (this.selected !== undefined) this.toggle(this.hiddenNames, this.selected); } };
    const key = Object.hasOwn(keys, event.key) ? keys[event.key] : undefined;
    if (key) key();
    else if (/^[1-6]$/.test(event.key)) this.frame(event.key);
    else if (!this.toolbar.turn(event.key)) return;
    event.preventDefault();
  }
}
