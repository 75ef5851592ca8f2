"""Puts shapes into the world, and asks how far a sphere on its way is from them."""

import numpy as np

import cwm

with cwm.connect(world="put_and_query") as world:
    world.apply(
        [
            cwm.Put("shelf", cwm.Box(0.4, 1.0, 0.03), cwm.pose([0.6, 0, 0.5])),
            cwm.Put("can", cwm.Cylinder(0.033, 0.12), cwm.pose([0.55, 0.1, 0.575])),
        ]
    )
    way = np.tile(np.eye(4), (5, 1, 1))
    way[:, :3, 3] = np.linspace([0.2, 0.1, 0.58], [0.6, 0.1, 0.58], 5)
    answer = world.distance(cwm.Sphere(0.02), way)
    for x_m, distance_m, name in zip(way[:, 0, 3], answer.distance_m, answer.objects):
        print(f"x = {x_m:.2f} m: {1000 * distance_m:7.1f} mm to {name}")
    motion = world.motions(cwm.Sphere(0.02), way[:1], way[-1:])
    verdict = cwm.MotionVerdict(motion.verdict[0]).name
    print(f"{verdict} at {100 * motion.hi[0]:.0f} % of the way, with {motion.objects[0]}")
