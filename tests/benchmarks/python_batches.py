"""The Python client's part of python_benchmark.cc: the same batches, timed; prints JSON.

python_batches.py ADDRESS WORLD ROBOT GROUP STATES_FILE ROWS BATCHES
"""

import json
import sys
import time

import numpy as np

import cwm


# The same number as in python_benchmark.cc: a new connection adapts its flow-control window first.
WARM_UP = 10


def main() -> None:
    address, world_name, robot, group, file_name, rows, batches = sys.argv[1:]
    states = np.fromfile(file_name, dtype="<f8").reshape(int(rows), -1)
    subject = cwm.RobotSubject(robot, group, geometry="spheres_as_given")
    with cwm.connect(address, world_name) as world:
        for _ in range(WARM_UP):
            world.check(subject, states, verdicts_only=True)
        times_s = []
        for _ in range(int(batches)):
            start = time.perf_counter()
            answer = world.check(subject, states, verdicts_only=True)
            collisions = int(np.count_nonzero(answer.collision))
            times_s.append(time.perf_counter() - start)
    print(json.dumps({"batch_s": float(np.median(times_s)), "collisions": collisions}))


main()
