"""Shows the world a scan, and lists what it found."""

import cwm
from table_scan import camera_pose, table_scan

with cwm.connect() as world:
    scan = world.ingest(table_scan(), x_world_sensor=camera_pose())
    report = scan.report
    print(f"{report.points_explained} of {report.points_finite} points explained")
    for thing in (*scan.supports, *scan.objects):
        count = scan.mask(thing).sum()
        print(f"{thing.name} ({thing.kind.name}) at {thing.position.round(3)}, {count} points")
        for part in thing.parts:
            print(f"    {part.shape}")
            if part.fit is not None:
                print(f"        rms {1000 * part.fit.rms_m:.1f} mm")
