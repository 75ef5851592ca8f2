// Running sensors: what the page says of them, calls that go at the page's pace, points in buffers
// that stay, and the age of the picture.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Vector3 } from "three";
import { create, toBinary } from "@bufbuild/protobuf";
import { WatchFramesResponseSchema } from "../../../clients/web/generated/cwm/v1/perception_pb";
import { messageOf } from "../../../clients/web/src/viewer/codec";
import { FramePacer } from "../../../clients/web/src/viewer/draw/frame_pacer";
import { PointBuffers } from "../../../clients/web/src/viewer/draw/live_points";
import { PacedCalls } from "../../../clients/web/src/viewer/paced_calls";
import { PictureLatency } from "../../../clients/web/src/viewer/picture_latency";
import { pixelClasses } from "../../../clients/web/src/viewer/pixel_classes";
import { dimmed, isDimmed, isStriped, statusText } from "../../../clients/web/src/viewer/object_status";
import { ageText, calibrationText, latencyText, lossText, rateText, shareText } from "../../../clients/web/src/viewer/sensor_text";
import { PixelClass } from "../../../clients/web/generated/cwm/v1/perception_pb";
import type { PixelCounts, Sensor } from "../../../clients/web/src/world/stream";

const sensor = (more: Partial<Sensor> = {}): Sensor => ({
  name: "front", is_streaming: true, frame_rate: 29.97, latency_p50_ms: 8.26, latency_p95_ms: 14, processed_count: "1200",
  dropped_count: "3", refused_count: "0", conflicts: [], ...more });

test("a sensor is told in numbers that can be read", () => {
  assert.equal(rateText(sensor()), "30 /s");
  assert.equal(rateText(sensor({ frame_rate: 4.04 })), "4.0 /s");
  assert.equal(rateText(sensor({ is_streaming: false })), "stopped");
  assert.equal(latencyText(sensor()), "8.3 ms, p95 14");
  assert.equal(latencyText(sensor({ processed_count: "0" })), "");
  assert.equal(lossText(sensor()), "3 dropped");
  const pixels = (robot: string, missing: string): PixelCounts => ({ consistent: "0", nearer: "0", farther: "0", missing, robot, carried: "0", mixed: "0", hidden: "0" });
  assert.equal(shareText("robot", [pixels("100", "300"), pixels("0", "600")]), "10 %");
  assert.equal(shareText("robot", [pixels("97", "903")]), "9.7 %");
  assert.equal(shareText("robot", []), "");
  assert.equal(lossText(sensor({ refused_count: "1500" })), "3 dropped, 1\u2009500 refused");
  assert.deepEqual([0.4, 12, 119, 180, 9000].map(ageText), ["now", "12 s ago", "119 s ago", "3 min ago", "3 h ago"]);
  assert.equal(calibrationText(sensor()), "");
  const estimate = { translation_error_m: 0.0042, rotation_error_rad: Math.PI / 180, surface_count: "3" };
  assert.equal(calibrationText(sensor({ estimate })), "pose off by 4.2 mm, 1.00°");
  assert.equal(calibrationText(sensor({ estimate, conflicts: ["old", "sees 12 mm beside left"] })), "sees 12 mm beside left");
});

test("an object is marked for what is worth a mark", () => {
  const facts = (motion: string, visibility: string, state = "OBJECT_STATE_CONFIRMED"): Parameters<typeof statusText>[0] =>
    ({ motion: `MOTION_${motion}`, visibility: `VISIBILITY_${visibility}`, state });
  assert.equal(statusText(facts("AT_REST", "VISIBLE")), "");
  assert.equal(statusText(facts("MOVING", "VISIBLE")), "moving");
  assert.equal(statusText(facts("MOVING", "OCCLUDED")), "moving, occluded");
  assert.equal(statusText(facts("AT_REST", "STALE")), "stale");
  assert.equal(statusText(facts("UNSPECIFIED", "UNSPECIFIED", "OBJECT_STATE_LOST")), "lost");
  assert.equal(statusText(facts("AT_REST", "VISIBLE", "OBJECT_STATE_OCCLUDED")), "", "running sensors know better than the last scan");
  const marks = (visibility: string): boolean[] => [isDimmed, isStriped].map((is) => is(facts("AT_REST", visibility)));
  assert.deepEqual(["UNSPECIFIED", "VISIBLE", "OCCLUDED", "STALE", "LOST"].map(marks),
                   [[false, false], [false, false], [true, false], [false, true], [true, true]]);
  assert.match(dimmed("#d55e00"), /^#[0-9a-f]{6}$/);
  assert.notEqual(dimmed("#d55e00"), dimmed("#0072b2"), "its colour can still be told");
});

test("the newest message waits while the reader is busy, and none queues up", () => {
  const calls = new PacedCalls<string>();
  calls.begin(1);
  assert.equal(calls.offer(1, "a"), "a");
  assert.equal(calls.offer(1, "b"), undefined);
  assert.equal(calls.offer(1, "c"), undefined);
  assert.equal(calls.next(1), "c");
  assert.equal(calls.offer(1, "d"), undefined, "the reader has not asked since c");
  assert.equal(calls.next(1), "d");
  assert.equal(calls.next(1), undefined);
  assert.equal(calls.offer(1, "e"), "e", "it is awaited");
  assert.equal(calls.offer(2, "x"), "x", "of a call that is not paced");
  assert.equal(calls.offer(2, "y"), "y");
  calls.offer(1, "f");
  calls.end(1);
  assert.equal(calls.next(1), undefined);
});

const bytesOf = (values: readonly number[]): Uint8Array => new Uint8Array(new Float32Array(values).buffer);

test("points come as bytes in the buffer that was received, and everything else as JSON", () => {
  const sent = toBinary(WatchFramesResponseSchema, create(WatchFramesResponseSchema, {
    sensor: "front", worldUid: "w", latencyMs: 7.5, points: bytesOf([1, 2, 3, 4, 5, 6]), classes: new Uint8Array([1, 5]),
    pixels: { nearer: 12n } }));
  const { message, buffers } = messageOf("PerceptionService/WatchFrames", sent);
  assert.deepEqual(buffers, [sent.buffer]);
  const { points, classes, sensor: name, latency_ms, pixels } = message as {
    points: Uint8Array; classes: Uint8Array; sensor: string; latency_ms: number; pixels: Record<string, string> };
  assert.equal(points.buffer, sent.buffer);
  assert.deepEqual([name, latency_ms, pixels["nearer"], [...classes]], ["front", 7.5, "12", [1, 5]]);
  assert.deepEqual([...new Float32Array(points.slice().buffer)], [1, 2, 3, 4, 5, 6]);
});

test("an empty frame has no buffer to hand over twice", () => {
  const { message, buffers } = messageOf("PerceptionService/WatchFrames", toBinary(WatchFramesResponseSchema, create(WatchFramesResponseSchema, {})));
  assert.deepEqual([buffers, (message["points"] as Uint8Array).length], [[], 0]);
});

test("frames are written into the buffers of the one before, which grow only for more points", () => {
  const buffers = new PointBuffers(2);
  const frame = (count: number, x: number): { sensor: string; points: Uint8Array; classes: Uint8Array } => {
    const padded = new Uint8Array(1 + 12 * count);  // not aligned, as in a message
    padded.set(bytesOf(Array.from({ length: 3 * count }, (_, i) => x + i)), 1);
    return { sensor: "front", points: padded.subarray(1), classes: new Uint8Array(count).fill(5) };
  };
  const arrays = (): unknown[] => ["position", "pixelClass"].map((name) => buffers.points.geometry.getAttribute(name).array);
  buffers.set(frame(1000, 0));
  const first = arrays();
  buffers.set(frame(4000, 7));
  buffers.set(frame(20, 9));
  assert.deepEqual(arrays().map((array, i) => array === first[i]), [true, true]);
  assert.equal(buffers.count, 20);
  assert.equal(buffers.points.geometry.drawRange.count, 20);
  assert.deepEqual(buffers.placeOf(1, new Vector3()).toArray(), [12, 13, 14]);
  assert.equal(buffers.classOf(19), 5);
  buffers.set(frame(30_000, 1));
  const grown = arrays();
  assert.notEqual(grown[0], first[0]);
  buffers.set(frame(20_000, 1));
  assert.deepEqual(arrays(), grown);
  assert.throws(() => buffers.set({ ...frame(3, 0), classes: new Uint8Array(4) }), /36 bytes of sensor front, must be 12 for each of 4 classes/);
});

test("the classes have the numbers of the enum", () => {
  pixelClasses.forEach(({ key }, i) => assert.equal(PixelClass[key.toUpperCase() as keyof typeof PixelClass], i + 1));
});

test("the picture is as old as its oldest message that was not drawn, with the server's time and the way", () => {
  const latency = new PictureLatency();
  latency.drawn(100);
  assert.equal(latency.parts(), undefined, "nothing came");
  latency.served(8);
  for (const thereAndBack of [30, 2, 9]) latency.called(thereAndBack);
  latency.received(1000);
  latency.received(1020);
  latency.issued();
  latency.received(1025);  // comes too late for this picture
  latency.drawn(1030);
  assert.deepEqual(latency.parts(), { server_ms: 8, way_ms: 1, page_ms: 30 });
  latency.drawn(1040);
  assert.equal(latency.parts()?.page_ms, 30, "a picture without news is no slow one");
  latency.issued();
  latency.drawn(1035);
  for (const page_ms of [10, 12, 900, 11]) {
    latency.received(2000);
    latency.issued();
    latency.drawn(2000 + page_ms);
  }
  assert.equal(latency.parts()?.page_ms, 12, "one slow picture does not matter");
});

test("pictures are drafts while they follow each other and cost much, and the last one is drawn well", () => {
  const pacer = new FramePacer();
  let now = 0;
  const draw = (cost_ms: number, pause_ms: number): string => {
    const quality = pacer.begin(now += pause_ms);
    assert.ok(pacer.isBusy);
    pacer.finish(now += cost_ms);
    assert.ok(!pacer.isBusy);
    return quality;
  };
  assert.deepEqual([draw(20, 0), draw(20, 10), draw(20, 10)], ["full", "full", "full"], "a fast one needs no drafts");
  assert.deepEqual([draw(300, 10), draw(90, 10), draw(90, 30)], ["full", "draft", "draft"]);
  assert.ok(pacer.isDraft);
  assert.equal(draw(300, 250), "full", "nothing moves any more");
  assert.deepEqual([draw(90, 10), draw(20, 10), draw(60, 10)], ["draft", "draft", "full"], "it has become faster");
});
