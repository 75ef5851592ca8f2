"""Shows the world a scan, and lists what it found."""

import cwm
from table_scan import camera_pose, table_scan

with cwm.connect(world="ingest_and_list") as world:
    scan = world.ingest(table_scan(), x_world_sensor=camera_pose())
    report = scan.report
    print(f"{report.points_explained} of {report.points_finite} points explained")
    for obj in (*scan.supports, *scan.objects):
        count = scan.mask(obj).sum()
        print(f"{obj.name} ({obj.kind.name}) at {obj.position.round(3)}, {count} points")
        for part in obj.parts:
            print(f"    {part.shape}")
            if part.fit is not None:
                print(f"        rms {1000 * part.fit.rms_m:.1f} mm")
