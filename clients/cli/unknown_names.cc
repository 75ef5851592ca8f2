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
  std::vector<std::string> names = KnownNames(session, NameKind::kObject);
  if (names.size() >= kMaxNames) return {};
  const std::vector<std::string> robots = KnownNames(session, NameKind::kRobot);
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

void WarnAboutPairMember(Session& session, const pb::NamedThing& member,
                         const std::vector<std::string>& names) {
  if (member.name() == kEverything || names.empty()) return;
  if (!Has(names, member.name())) {
    const auto nearest = NearestWord(member.name(), names);
    if (!nearest) return;
    return WarnWithNearest(session, absl::StrCat("nothing is named \"", member.name(), "\" yet"),
                           nearest);
  }
  if (!member.link().empty()) WarnAboutUnknownLinks(session, member.name(), {member.link()});
}

}  // namespace

void WarnAboutUnknownNames(Session& session, const pb::QueryOptions& options) {
  if (options.ignore().empty() && options.ignore_pairs().empty()) return;
  const std::vector<std::string> names = NamesOfWorld(session);
  if (names.empty()) return;
  for (const std::string& name : options.ignore()) {
    if (Has(names, name)) continue;
    WarnWithNearest(session, absl::StrCat("--ignore: nothing is named \"", name, "\""),
                    NearestWord(name, names));
  }
  for (const pb::NamedPair& pair : options.ignore_pairs()) {
    WarnAboutPairMember(session, pair.a(), names);
    WarnAboutPairMember(session, pair.b(), names);
  }
}

void WarnAboutUnknownNames(Session& session, const pb::NamedPair& pair) {
  const std::vector<std::string> names = NamesOfWorld(session);
  WarnAboutPairMember(session, pair.a(), names);
  WarnAboutPairMember(session, pair.b(), names);
}

void WarnAboutUnknownLinks(Session& session, const std::string& robot,
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
