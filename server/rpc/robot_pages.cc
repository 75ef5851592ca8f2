#include "server/rpc/robot_pages.h"

#include "absl/strings/str_cat.h"
#include "server/core/load_robot.h"
#include "server/rpc/pages.h"
#include "server/wire/objects.h"
#include "server/wire/robots.h"

namespace cwm::server {
namespace {

absl::Status CheckNameIfAny(const std::string& name) {
  return name.empty() ? absl::OkStatus() : CheckName(name, FieldPath::OfRequest("name"));
}

absl::Status CheckKnown(const std::string& name, const collision::WorldSnapshot& snapshot) {
  const bool is_known = name.empty() || snapshot.FindRobot(name) != nullptr;
  return is_known ? absl::OkStatus() : UnknownRobot(name);
}

}  // namespace

absl::Status ListPage(Runtime& runtime, const v1::ListRobotsRequest& request,
                      const CallContext& call, v1::ListRobotsResponse* response) {
  auto size = PageSizeOf(request.page_size());
  if (!size.ok()) return size.status();
  if (auto status = CheckNameIfAny(request.name()); !status.ok()) return status;
  auto source = FindPage(runtime,
                         {.world = request.world(),
                          .world_uid = request.world_uid(),
                          .at_revision = request.at_revision(),
                          .page_token = request.page_token(),
                          .filter = absl::StrCat("robots ", request.name())},
                         call);
  if (!source.ok()) return source.status();
  const collision::WorldSnapshot& snapshot = *source->at.snapshot;
  if (auto status = CheckKnown(request.name(), snapshot); !status.ok()) return status;
  response->set_world_uid(source->at.world->uid());
  response->set_revision(snapshot.revision().value);
  std::size_t bytes = 0;
  for (const collision::WorldRobotPtr& robot : snapshot.robots()) {
    if (robot->name <= source->after) continue;
    if (!request.name().empty() && robot->name != request.name()) continue;
    if (static_cast<std::size_t>(response->robots_size()) == *size || bytes >= kPageBytes) {
      response->set_next_page_token(NextToken(*source, response->robots().rbegin()->name()));
      break;
    }
    v1::Robot* proto = response->add_robots();
    *proto = RobotToProto(*robot);
    bytes += proto->ByteSizeLong();
  }
  return absl::OkStatus();
}

}  // namespace cwm::server
