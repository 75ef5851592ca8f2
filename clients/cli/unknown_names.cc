#include "clients/cli/unknown_names.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "absl/strings/str_cat.h"
#include "clients/cli/known_names.h"
#include "clients/cli/nearest_word.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

constexpr char kEverything[] = "*";

bool Has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// The names of objects and robots of the world; empty if they cannot be read completely.
std::vector<std::string> NamesOfWorld(const Session& session) {
  std::vector<std::string> names = KnownNames(session, Named::kObject);
  if (names.size() >= kMaxNames) return {};
  const std::vector<std::string> robots = KnownNames(session, Named::kRobot);
  names.insert(names.end(), robots.begin(), robots.end());
  return names;
}

std::vector<std::string> LinksOf(Session& session, const std::string& robot) {
  pb::ListRobotsRequest request;
  request.set_world(session.world);
  request.set_name(robot);
  const client::Connection& connection = session.connection();
  const auto listed =
      connection.Call(&pb::RobotService::Stub::ListRobots, connection.robots(), request);
  std::vector<std::string> links;
  if (!listed.ok() || listed->robots_size() != 1) return links;
  for (const pb::RobotLink& link : listed->robots(0).links()) links.push_back(link.name());
  return links;
}

void WarnWithNearest(Session& session, const std::string& warning,
                     const std::optional<std::string>& nearest) {
  session.Warn(nearest ? absl::StrCat(warning, "; did you mean ", *nearest, "?") : warning);
}

void WarnOfThing(Session& session, const pb::NamedThing& thing,
                 const std::vector<std::string>& names) {
  if (thing.name() == kEverything || names.empty()) return;
  if (!Has(names, thing.name())) {
    const auto nearest = NearestWord(thing.name(), names);
    if (!nearest) return;
    return WarnWithNearest(session, absl::StrCat("nothing is named \"", thing.name(), "\" yet"),
                           nearest);
  }
  if (!thing.link().empty()) WarnOfUnknownLinks(session, thing.name(), {thing.link()});
}

}  // namespace

void WarnOfUnknownNames(Session& session, const pb::QueryOptions& options) {
  if (options.ignore().empty() && options.ignore_pairs().empty()) return;
  const std::vector<std::string> names = NamesOfWorld(session);
  if (names.empty()) return;
  for (const std::string& name : options.ignore()) {
    if (Has(names, name)) continue;
    WarnWithNearest(session, absl::StrCat("--ignore: nothing is named \"", name, "\""),
                    NearestWord(name, names));
  }
  for (const pb::NamedPair& pair : options.ignore_pairs()) {
    WarnOfThing(session, pair.a(), names);
    WarnOfThing(session, pair.b(), names);
  }
}

void WarnOfUnknownNames(Session& session, const pb::NamedPair& pair) {
  const std::vector<std::string> names = NamesOfWorld(session);
  WarnOfThing(session, pair.a(), names);
  WarnOfThing(session, pair.b(), names);
}

void WarnOfUnknownLinks(Session& session, const std::string& robot,
                        const std::vector<std::string>& links) {
  const std::vector<std::string> known = LinksOf(session, robot);
  if (known.empty()) return;
  for (const std::string& link : links) {
    if (Has(known, link)) continue;
    WarnWithNearest(session, absl::StrCat("\"", robot, "\" has no link \"", link, "\""),
                    NearestWord(link, known));
  }
}

}  // namespace cwm::cli
