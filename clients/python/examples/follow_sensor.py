"""Follows a world with a running camera before a table, and prints what changes."""

import time

import table_scan

import cwm

WIDTH, HEIGHT = 320, 240
INTRINSICS = (0.82 * WIDTH, 0.82 * WIDTH, (WIDTH - 1) / 2, (HEIGHT - 1) / 2)

with cwm.connect(world="follow_sensor") as world:
    # The depth along the optical axis; NaN: no return.
    images = [table_scan.table_scan(WIDTH, HEIGHT, seed)[..., 2] for seed in range(5)]
    with world.stream_sensor("table", INTRINSICS, table_scan.camera_pose()) as frames:
        for k in range(60):
            result = frames.process(images[k % len(images)], time.time())
            if result.fate is not cwm.FrameFate.PROCESSED:
                print(f"frame {result.frame}: {result.reason}: {result.message}")
            if result.changes:
                print(f"frame {result.frame}, revision {result.revision}: {result.changes}")
            time.sleep(1 / 30)
    for thing in world.objects():
        print(thing.name, thing.motion.name, thing.visibility.name)
    for sensor in world.sensors():
        print(f"{sensor.name}: {sensor.processed_count} frames, {sensor.latency_p50_ms:.1f} ms")
