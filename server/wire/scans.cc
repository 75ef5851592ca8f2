#include "server/wire/scans.h"

#include "server/wire/poses.h"
#include "server/wire/times.h"

namespace cwm::server {

v1::Scan ScanToProto(const KeptScan& scan) {
  v1::Scan proto;
  proto.set_sensor(scan.sensor);
  proto.set_revision(scan.revision.value);
  *proto.mutable_frame_stamp() = TimePointToProto(scan.frame_stamp);
  *proto.mutable_x_world_sensor() = PoseToProto(scan.X_WC);
  proto.set_point_count(scan.point_count);
  proto.set_kept_count(scan.kept_count);
  proto.set_points_hash(scan.points.hash);
  proto.set_labels_hash(scan.labels.hash);
  proto.mutable_supports()->Assign(scan.supports.begin(), scan.supports.end());
  proto.mutable_objects()->Assign(scan.objects.begin(), scan.objects.end());
  return proto;
}

}  // namespace cwm::server
