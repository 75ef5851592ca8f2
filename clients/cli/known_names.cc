#include "clients/cli/known_names.h"

#include <chrono>

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

// chosen: somebody is waiting at the keyboard.
constexpr std::chrono::milliseconds kPatience(500);

}  // namespace

std::vector<std::string> KnownNames(const Session& session, NameKind kind) {
  client::ConnectOptions options;
  if (!session.address.empty()) options.address = session.address;
  options.deadline = kPatience;
  const client::Connection connection(options);
  std::vector<std::string> names;
  if (kind == NameKind::kWorld) {
    const auto listed =
        connection.Call(&pb::WorldService::Stub::ListWorlds, connection.worlds(), {});
    if (!listed.ok()) return names;
    for (const pb::World& world : listed->worlds()) names.push_back(world.name());
  } else if (kind == NameKind::kRobot) {
    pb::ListRobotsRequest request;
    request.set_world(session.world);
    const auto listed =
        connection.Call(&pb::RobotService::Stub::ListRobots, connection.robots(), request);
    if (!listed.ok()) return names;
    for (const pb::Robot& robot : listed->robots()) names.push_back(robot.name());
  } else {
    pb::ListObjectsRequest request;
    request.set_world(session.world);
    request.set_view(pb::OBJECT_VIEW_BASIC);
    request.set_page_size(static_cast<int>(kMaxNames));
    const auto listed =
        connection.Call(&pb::WorldService::Stub::ListObjects, connection.worlds(), request);
    if (!listed.ok()) return names;
    for (const pb::Object& object : listed->objects()) names.push_back(object.name());
  }
  return names;
}

}  // namespace cwm::cli
