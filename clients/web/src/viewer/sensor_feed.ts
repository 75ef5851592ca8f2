// Follows the running sensors of one world: a list now and then, and, while somebody looks at them,
// the points of their newest frames at the pace at which the page draws them.
import type { Sensor, SensorPoints } from "../world/stream";
import { notFound, now_ms, resourceExhausted, unavailable, unimplemented } from "./messages";
import { CallFailure, type PacedStream, type RpcClient } from "./rpc_client";

// chosen: figures that people read.
const listPeriod_ms = 1000;

// chosen: enough to see what happens; each frame costs the server a copy and the socket 0.3 MB.
const frameRate_hz = 10;
const maxPoints = 20_000;

// chosen: below the calls that a page may have, with room for queries.
const maxStreams = 8;

export interface SensorListener {
  sensors: (sensors: readonly Sensor[], thereAndBack_ms: number) => void;
  points: (points: SensorPoints, received_ms: number) => void;
  failed: (message: string) => void;
}

export class SensorFeed {
  private world: string | undefined;  // undefined: no connection, or no world
  private sensors: readonly Sensor[] = [];
  private readonly streams = new Map<string, PacedStream>();
  private readonly undrawn = new Set<string>();  // sensors whose newest points are not drawn yet
  private arePointsWanted = false;
  private timer = 0;
  private generation = 0;  // answers to calls of an older one are not used

  constructor(private readonly client: RpcClient, private readonly listener: SensorListener) {}

  // Begins anew with the sensors of this world; undefined: with none.
  follow(world: string | undefined): void {
    ++this.generation;
    window.clearTimeout(this.timer);
    this.closeAll();
    const isOther = this.world !== world;
    this.world = world;
    if (isOther) this.hear([], 0);
    void this.list();
  }

  wantPoints(areWanted: boolean): void {
    this.arePointsWanted = areWanted;
    this.openAndClose();
  }

  // Asks for the next points of the sensors whose points the last picture had.
  drawn(): void {
    for (const sensor of this.undrawn) this.streams.get(sensor)?.next();
    this.undrawn.clear();
  }

  private hear(sensors: readonly Sensor[], thereAndBack_ms: number): void {
    this.sensors = sensors;
    this.openAndClose();
    this.listener.sensors(sensors, thereAndBack_ms);
  }

  private async list(): Promise<void> {
    const { world, generation } = this;
    if (world === undefined) return;
    const began_ms = now_ms();
    let isOver = false;
    try {
      const { sensors } = await this.client.call<{ sensors: Sensor[] }>("PerceptionService/ListSensors", { world });
      if (generation === this.generation) this.hear(sensors, now_ms() - began_ms);
    } catch (error) {
      if (!(error instanceof CallFailure)) throw error;
      const { code } = error.error;
      isOver = code === unimplemented;
      if (generation === this.generation && code === notFound) this.hear([], 0);
    }
    if (generation === this.generation && !isOver) this.timer = window.setTimeout(() => void this.list(), listPeriod_ms);
  }

  private openAndClose(): void {
    const streaming = this.sensors.filter(({ is_streaming }) => is_streaming).map(({ name }) => name);
    const wanted = new Set(this.arePointsWanted ? streaming.slice(0, maxStreams) : []);
    for (const [sensor, stream] of this.streams) {
      if (wanted.has(sensor)) continue;
      stream.cancel();
      this.forget(sensor);
    }
    for (const sensor of wanted) if (!this.streams.has(sensor)) this.open(sensor);
  }

  private open(sensor: string): void {
    const request = { world: this.world ?? "", sensor, max_points: maxPoints, max_rate_hz: frameRate_hz };
    this.streams.set(sensor, this.client.pacedStream<SensorPoints>("PerceptionService/WatchFrames", request, {
      message: (points, received_ms) => {
        this.undrawn.add(sensor);
        this.listener.points(points, received_ms);
      },
      end: (error) => {  // opened again with the next list
        this.forget(sensor);
        if (error && ![notFound, resourceExhausted, unavailable, unimplemented].includes(error.code)) this.listener.failed(error.message);
      } }));
  }

  private closeAll(): void {
    for (const [sensor, stream] of this.streams) {
      stream.cancel();
      this.forget(sensor);
    }
  }

  private forget(sensor: string): void {
    this.streams.delete(sensor);
    this.undrawn.delete(sensor);
  }
}
