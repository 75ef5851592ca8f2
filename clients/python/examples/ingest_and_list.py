"""Shows the world a scan, and lists what it found."""

import cwm
from table_scan import camera_pose, table_scan

with cwm.connect() as world:
    scan = world.ingest(table_scan(), x_world_sensor=camera_pose())
    print(
        f"revision {scan.revision}: {scan.report.points_explained} of {scan.report.points_finite} points explained"
    )
    for thing in (*scan.supports, *scan.objects):
        print(
            f"{thing.name} ({thing.kind.name}) at {thing.position.round(3)}, {scan.mask(thing).sum()} points"
        )
        for part in thing.parts:
            print(
                f"    {part.shape}  {'' if part.fit is None else f'rms {1000 * part.fit.rms_m:.1f} mm'}"
            )
