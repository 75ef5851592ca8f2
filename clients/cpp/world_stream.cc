#include "clients/cpp/world_stream.h"

#include <memory>
#include <utility>

#include "cwm/internal/geometry_messages.h"
#include "cwm/internal/session.h"

namespace cwm::client {

absl::StatusOr<api::WorldView> StreamWorld(
    const Connection& connection, const WorldRevision& at,
    const google::protobuf::RepeatedPtrField<v1::Change>& overlay) {
  auto info = connection.Call(&v1::AdminService::Stub::GetServerInfo, connection.admin(),
                              v1::GetServerInfoRequest());
  if (!info.ok()) return info.status();
  api::internal::View view{
      .session = std::make_shared<api::internal::Session>(connection.WithDeadline({})),
      .connection = {},
      .stream = {},
      .world = at.world,
      .uid = at.world_uid,
      .pinned = at.revision};
  view.session->limits = std::move(*info->mutable_limits());
  view.connection = std::make_shared<Connection>(connection.WithDeadline({}));
  view.stream = std::make_shared<QueryStream>(view.session->connection);
  if (!overlay.empty()) {
    v1::StreamQueriesRequest request;
    request.mutable_overlay()->set_world(at.world);
    *request.mutable_overlay()->mutable_changes() = overlay;
    const auto taken = view.stream->Evaluate(request);
    if (!taken.ok()) return taken.status();
  }
  return api::internal::MakeView(std::make_shared<const api::internal::View>(std::move(view)));
}

Eigen::Isometry3d ToIsometry(const v1::Pose& pose) { return api::internal::FromMessage(pose); }

Eigen::Isometry3d ToIsometry(const PoseRow& row) {
  return api::internal::PoseFromNumbers(row.data());
}

}  // namespace cwm::client
