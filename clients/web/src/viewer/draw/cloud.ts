// The newest scans, each point in the colour of its object.
import { BufferAttribute, BufferGeometry, Color, Group, Points, PointsMaterial } from "three";
import type { Scan } from "../../world/stream";
import { fetchBlob } from "./blobs";

const isSame = (a: Scan | undefined, b: Scan): boolean =>
  a?.points_hash === b.points_hash && a.labels_hash === b.labels_hash;

interface SensorCloud { scan: Scan; points: Points; labels: Uint32Array; painted: ReadonlyMap<number, string>; }

export const looseColor = "#8a8f98";  // of unassigned points

// The name that a label refers to; see Scan in perception.proto.
export function ownerOfLabel(label: number, scan: Scan): string | undefined {
  if (label === 0) return undefined;
  if (label < 10) return scan.supports[label - 1];
  return scan.objects[Math.floor(label / 10) - 2];
}

export class Clouds {
  readonly root = new Group();
  private readonly held = new Map<string, SensorCloud>();
  private wanted = new Map<string, Scan>();
  private readonly loading = new Set<string>();  // sensors; one load of each at a time
  private size_px = 2;

  constructor(private readonly colorOf: (name: string) => string | undefined, private readonly changed: () => void,
              private readonly failed: (why: string) => void) {}

  get pointCount(): number {
    return [...this.held.values()].reduce((sum, { labels }) => sum + labels.length, 0);
  }

  setSize(size_px: number): void {
    this.size_px = size_px;
    for (const { points } of this.held.values()) (points.material as PointsMaterial).size = size_px;
  }

  // Fetches new scans and keeps the old picture until they have been received.
  sync(scans: readonly Scan[]): void {
    this.wanted = new Map(scans.map((scan) => [scan.sensor, scan]));
    for (const [sensor, held] of this.held) {
      if (!this.wanted.has(sensor)) this.drop(sensor, held);
    }
    for (const { sensor } of scans) {
      if (this.loading.has(sensor)) continue;
      this.loading.add(sensor);
      this.follow(sensor).catch((error: unknown) => this.failed(error instanceof Error ? error.message : String(error)))
        .finally(() => this.loading.delete(sensor));
    }
  }

  // Called after a change of the world: most changes keep the colours, and then a million points
  // are left untouched.
  recolor(): void {
    for (const held of this.held.values()) {
      if ([...held.painted].some(([label, color]) => this.colorOfLabel(label, held.scan) !== color)) this.paint(held);
    }
  }

  // Loads until the held scan is the wanted one: scans that follow each other faster than they
  // arrive are shown or skipped, and the last one is shown.
  private async follow(sensor: string): Promise<void> {
    for (let scan = this.wanted.get(sensor); scan && !isSame(this.held.get(sensor)?.scan, scan); scan = this.wanted.get(sensor)) {
      try {
        await this.load(scan);
      } catch (error) {  // does not matter if another scan has replaced it
        if (this.isWanted(scan)) throw error;
      }
    }
  }

  private isWanted(scan: Scan): boolean { return isSame(this.wanted.get(scan.sensor), scan); }

  private async load(scan: Scan): Promise<void> {
    const [points, labels] = await Promise.all(
      [scan.points_hash, scan.labels_hash].map((hash) => fetchBlob(hash, () => this.isWanted(scan))));
    if (!points || !labels) return;
    if (!this.wanted.has(scan.sensor)) return;
    const before = this.held.get(scan.sensor);
    if (before) this.drop(scan.sensor, before);
    const held = { scan, points: this.cloudOf(points), labels: new Uint32Array(labels), painted: new Map() };
    this.held.set(scan.sensor, held);
    this.paint(held);
    this.root.add(held.points);
    this.changed();
  }

  private cloudOf(bytes: ArrayBuffer): Points {
    const places = new Float32Array(bytes);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(places, 3));
    geometry.setAttribute("color", new BufferAttribute(new Uint8Array(places.length), 3, true));
    const material = new PointsMaterial({ size: this.size_px, sizeAttenuation: false, vertexColors: true });
    const points = new Points(geometry, material);
    points.matrixAutoUpdate = false;
    return points;
  }

  private paint(held: SensorCloud): void {
    const { scan, points, labels } = held;
    const colors = points.geometry.getAttribute("color");
    const bytes = colors.array as Uint8Array;
    const known = new Map<number, readonly [number, number, number]>();
    for (let i = 0; i < labels.length; ++i) {
      const label = labels[i] ?? 0;
      const [r, g, b] = known.get(label) ?? this.colorBytes(label, scan, known);
      bytes[3 * i] = r;
      bytes[3 * i + 1] = g;
      bytes[3 * i + 2] = b;
    }
    colors.needsUpdate = true;
    held.painted = new Map([...known.keys()].map((label) => [label, this.colorOfLabel(label, scan)]));
  }

  private colorOfLabel(label: number, scan: Scan): string {
    const name = ownerOfLabel(label, scan);
    return (name !== undefined && this.colorOf(name)) || looseColor;
  }

  private colorBytes(label: number, scan: Scan, known: Map<number, readonly [number, number, number]>):
      readonly [number, number, number] {
    const color = new Color(this.colorOfLabel(label, scan));
    const made = [255 * color.r, 255 * color.g, 255 * color.b] as const;
    known.set(label, made);
    return made;
  }

  private drop(sensor: string, { points }: SensorCloud): void {
    this.root.remove(points);
    points.geometry.dispose();
    (points.material as PointsMaterial).dispose();
    this.held.delete(sensor);
  }
}
