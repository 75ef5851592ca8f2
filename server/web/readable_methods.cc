#include "server/web/readable_methods.h"

#include <algorithm>

namespace cwm::server {
namespace {

constexpr std::string_view kMethods[] = {
    "cwm.v1.AdminService/GetServerInfo",    "cwm.v1.PerceptionService/ListScans",
    "cwm.v1.PerceptionService/ListSensors", "cwm.v1.PerceptionService/WatchFrames",
    "cwm.v1.QueryService/CastRays",         "cwm.v1.QueryService/CheckCollisions",
    "cwm.v1.QueryService/CheckMotions",     "cwm.v1.QueryService/GetContacts",
    "cwm.v1.QueryService/GetDistances",     "cwm.v1.QueryService/GetWorldContacts",
    "cwm.v1.QueryService/SamplePoints",     "cwm.v1.QueryService/SolvePoses",
    "cwm.v1.RobotService/GetLinkPoses",     "cwm.v1.RobotService/GetRobotLinks",
    "cwm.v1.RobotService/ListRobots",       "cwm.v1.WorldService/GetObject",
    "cwm.v1.WorldService/GetWorld",         "cwm.v1.WorldService/ListObjects",
    "cwm.v1.WorldService/ListWorlds",       "cwm.v1.WorldService/ReadGeometry",
    "cwm.v1.WorldService/WatchWorld",
};

// Streams: they take as long as their reader needs, or do not end by themselves.
constexpr std::string_view kReadGeometry = "cwm.v1.WorldService/ReadGeometry";
constexpr std::string_view kWatchFrames = "cwm.v1.PerceptionService/WatchFrames";
constexpr std::string_view kWatchWorld = "cwm.v1.WorldService/WatchWorld";

}  // namespace

std::span<const std::string_view> ReadableMethods() { return kMethods; }

bool IsReadable(std::string_view method) {
  return std::binary_search(std::begin(kMethods), std::end(kMethods), method);
}

bool IsWatch(std::string_view method) { return method == kWatchWorld; }

bool IsStream(std::string_view method) {
  return IsWatch(method) || method == kReadGeometry || method == kWatchFrames;
}

}  // namespace cwm::server
