// Running sensors on the page: their panel, their live points in the picture, and the picture's age.
import type { PixelCounts, Sensor, SensorPoints } from "../world/stream";
import type { Picture } from "./draw/picture";
import { now_ms } from "./messages";
import { SensorPanel } from "./panels/sensor_panel";
import { PictureLatency } from "./picture_latency";
import type { RpcClient } from "./rpc_client";
import { SensorFeed } from "./sensor_feed";

// chosen: an older stamp is of another clock or of a recording.
const plausibleAge_ms = 24 * 3600 * 1000;

export class SensorController {
  readonly panel = new SensorPanel(() => this.turn(!this.isOn));
  private readonly feed: SensorFeed;
  private readonly latency = new PictureLatency();
  private readonly newest = new Map<string, { stamp: string; seen_ms: number }>();  // frames, by sensor
  private readonly pixels = new Map<string, PixelCounts>();  // of the newest points
  private world: string | undefined;
  private sensors: readonly Sensor[] = [];
  private isOn = false;
  private isPast = false;
  private frames = 0;

  // `turned` is called when the live points appear or go.
  constructor(client: RpcClient, private readonly picture: Picture, private readonly turned: () => void, failed: (message: string) => void) {
    this.feed = new SensorFeed(client, {
      sensors: (sensors, thereAndBack_ms) => this.hear(sensors, thereAndBack_ms),
      points: (points, received_ms) => this.take(points, received_ms), failed });
    document.addEventListener("visibilitychange", () => this.follow(this.world));
  }

  get areShown(): boolean { return this.isOn && !this.isPast && this.sensors.length > 0; }

  // undefined: no connection. A page that nobody looks at follows none.
  follow(world: string | undefined): void {
    this.world = world;
    this.feed.follow(document.hidden ? undefined : world);
    this.latency.reset();
  }

  turn(isOn: boolean): void {
    this.isOn = isOn;
    this.panel.turn(isOn);
    this.apply();
  }

  toggle(): void { if (this.sensors.length > 0) this.turn(!this.isOn); }

  // The past has no frames.
  showPast(isPast: boolean): void {
    if (this.isPast === isPast) return;
    this.isPast = isPast;
    this.apply();
  }

  stateReceived(received_ms: number): void { if (this.sensors.length > 0) this.latency.received(received_ms); }

  // Called when the commands of a picture are given, and when it is drawn.
  issued(): void { this.latency.issued(); }

  drawn(): void {
    this.latency.drawn(now_ms());
    this.feed.drawn();
  }

  facts(): Record<string, unknown> {
    return { live_points: this.areShown ? this.picture.livePoints.pointCount : 0, live_frames: this.frames, sensors: this.sensors.length,
             picture_latency: this.latency.parts() ?? null };
  }

  private apply(): void {
    this.feed.wantPoints(this.isOn && !this.isPast);
    this.picture.livePoints.root.visible = this.areShown;
    if (!this.isOn) this.picture.livePoints.keep(new Set());
    this.turned();
    this.picture.stage.requestRender();
  }

  private hear(sensors: readonly Sensor[], thereAndBack_ms: number): void {
    const wereAny = this.sensors.length > 0;
    this.sensors = sensors;
    const names = new Set(sensors.map(({ name }) => name));
    this.picture.livePoints.keep(names);
    for (const of of [this.newest, this.pixels]) for (const name of of.keys()) if (!names.has(name)) of.delete(name);
    for (const { name, last_frame, is_streaming } of sensors) if (last_frame !== undefined) this.note(name, last_frame, is_streaming);
    const streaming = sensors.filter(({ is_streaming }) => is_streaming);
    if (thereAndBack_ms > 0) this.latency.called(thereAndBack_ms);
    if (streaming.length > 0) this.latency.served(Math.max(...streaming.map(({ latency_p50_ms }) => latency_p50_ms)));
    else this.latency.reset();
    this.panel.show(sensors, new Map([...this.newest].map(([name, { seen_ms }]) => [name, (now_ms() - seen_ms) / 1000])));
    this.panel.showLatency(this.latency.parts());
    if (wereAny !== sensors.length > 0) this.apply();
  }

  private take(frame: SensorPoints, received_ms: number): void {
    ++this.frames;
    this.latency.received(received_ms);
    this.latency.served(frame.latency_ms);
    this.note(frame.sensor, frame.frame_stamp ?? "", true);
    this.picture.livePoints.set(frame);
    if (frame.pixels) this.pixels.set(frame.sensor, frame.pixels);
    this.panel.showShares([...this.pixels.values()]);
    this.picture.stage.requestRender();
  }

  // A frame's age counts from when the page learnt of it, since clocks of sensors may differ. Only for
  // a sensor that had stopped before, its stamp is the best that there is.
  private note(sensor: string, stamp: string, isStreaming: boolean): void {
    const before = this.newest.get(sensor);
    if (before?.stamp === stamp) return;
    const now = now_ms();
    const stamped_ms = Date.parse(stamp);
    const isPlausible = !before && !isStreaming && stamped_ms < now && now - stamped_ms < plausibleAge_ms;
    this.newest.set(sensor, { stamp, seen_ms: isPlausible ? stamped_ms : now });
  }
}
