"""Loads a robot, and asks about a hundred thousand of its states at once."""

import time

import numpy as np

import cwm

LINK = """<link name="{0}"><collision><origin xyz="0.2 0 0" rpy="0 1.5708 0"/>
    <geometry><cylinder radius="0.04" length="0.36"/></geometry></collision></link>"""
JOINT = """<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/>
    <origin xyz="0.4 0 0"/><axis xyz="0 {3} {4}"/><limit lower="-2.5" upper="2.5"/></joint>"""
LINKS = "".join(LINK.format(name) for name in ("base", "upper", "lower", "hand"))
URDF = f"""<robot name="arm">{LINKS}
    {JOINT.format("shoulder", "base", "upper", 0, 1)}
    {JOINT.format("elbow", "upper", "lower", 1, 0)}
    {JOINT.format("wrist", "lower", "hand", 0, 1)}</robot>"""

with cwm.connect(world="robot_batches") as world:
    arm = world.load_robot(URDF, pose=cwm.pose([0, 0, 0.5]))
    world.put("pillar", cwm.Cylinder(0.1, 2.0), cwm.pose([0.7, 0.5, 1.0]))
    lower, upper = arm.limits().T
    states = np.random.default_rng(1).uniform(lower, upper, (100_000, len(lower)))

    start = time.perf_counter()
    answer = world.check(cwm.RobotSubject("arm"), states)
    elapsed_s = time.perf_counter() - start
    rate = len(states) / elapsed_s
    print(f"{answer.free.sum()} of {len(states)} states are free ({rate:.0f} states/s)")
    hit = answer.objects[answer.collision]
    print(f"    {np.sum(hit == 'pillar')} hit the pillar, {np.sum(hit == '')} the robot itself")
