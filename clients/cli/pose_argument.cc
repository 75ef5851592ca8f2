#include "clients/cli/pose_argument.h"

#include <algorithm>

#include "clients/cli/mesh_frames.h"
#include "clients/cli/number_list.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

absl::StatusOr<client::PointRow> CentreOf(Session& session, const std::string& name) {
  const client::Connection& connection = session.connection();
  pb::GetObjectRequest request;
  request.set_world(session.world);
  request.set_name(name);
  request.set_view(pb::OBJECT_VIEW_BASIC);
  const auto found =
      connection.Call(&pb::WorldService::Stub::GetObject, connection.worlds(), request);
  if (!found.ok()) return found.status();
  const pb::Pose& box = found->object().bounds().x_object_box();
  const client::PointRow centre = {box.tx_m(), box.ty_m(), box.tz_m()};
  return TransformPoint(found->object().x_world_object(), centre);
}

}  // namespace

absl::StatusOr<client::PoseRow> ParsePoseArgument(Session& session, const std::string& text,
                                                  const std::string& option) {
  if (StartsWithNumber(text) || text.empty() || text.find(',') < text.find('+')) {
    return ParsePose(text, option);
  }
  const std::size_t plus = text.find('+');
  client::PoseRow place = {0, 0, 0, 0, 0, 0, 1};
  if (plus != std::string::npos) {
    const auto offset = ParseNumbers(text.substr(plus + 1), {option, "NAME+DX,DY,DZ (m)", 3});
    if (!offset.ok()) return offset.status();
    std::copy(offset->begin(), offset->end(), place.begin());
  }
  const auto centre = CentreOf(session, text.substr(0, plus));
  if (!centre.ok()) return centre.status();
  for (std::size_t i = 0; i < 3; ++i) place[i] += (*centre)[i];
  return place;
}

}  // namespace cwm::cli
