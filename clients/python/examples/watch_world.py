"""Follows a world while somebody else changes it."""

import threading

import cwm


def change(world: cwm.World) -> None:
    world.move("ball", cwm.pose([0.1, 0, 0.5]))
    world.put("cup", cwm.Cylinder(0.04, 0.1), cwm.pose([0.3, 0, 0.05]))
    world.remove("ball")


with cwm.connect(world="watch_world") as world:
    world.put("ball", cwm.Sphere(0.05), cwm.pose([0, 0, 0.5]))
    with world.watch() as happenings:
        for happening in happenings:
            if isinstance(happening, cwm.Snapshot):
                print(
                    f"revision {happening.revision}: {[obj.name for obj in happening.objects]}",
                    happening.anew,
                )
                threading.Thread(target=change, args=(world,)).start()
            elif isinstance(happening, cwm.Changes):
                kinds = [type(event).__name__ for event in happening.events]
                print(f"revision {happening.revision}: {kinds}")
                if cwm.ObjectRemoved("ball") in happening.events:
                    break
