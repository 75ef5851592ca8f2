#include "server/wire/pair_options.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "absl/strings/str_cat.h"
#include "server/wire/numbers.h"
#include "server/wire/objects.h"

namespace cwm::server {
namespace {

constexpr int kMaxNamedThings = 4'096;
constexpr int kMaxContactsOfPair = 1'024;

}  // namespace

absl::StatusOr<std::vector<collision::NamedThing>> NamedThingsFromProto(
    const google::protobuf::RepeatedPtrField<v1::NamedThing>& only, const FieldPath& path) {
  constexpr char kField[] = "only";
  auto status = CheckRange(only.size(), {0, kMaxNamedThings}, path.Field(kField));
  if (!status.ok()) return status;
  std::vector<collision::NamedThing> named;
  named.reserve(static_cast<std::size_t>(only.size()));
  for (int i = 0; i < only.size(); ++i) {
    const FieldPath item = path.Item(kField, i);
    if (only[i].name() == collision::kEverything) {
      return item.Field("name").Error(
          "is \"*\", must be the name of an object or a robot: an empty list restricts nothing");
    }
    status = CheckName(only[i].name(), item.Field("name"));
    if (!status.ok()) return status;
    named.push_back({only[i].name(), only[i].link()});
  }
  return named;
}

absl::Status CheckNamedThings(const std::vector<collision::NamedThing>& only,
                              const collision::WorldSnapshot& snapshot, const FieldPath& path) {
  for (std::size_t i = 0; i < only.size(); ++i) {
    const auto& [name, link] = only[i];
    const FieldPath item = path.Item("only", static_cast<int>(i));
    const collision::WorldRobotPtr robot = snapshot.FindRobot(name);
    if (robot == nullptr && snapshot.Find(name) == nullptr) {
      return item.Field("name").Error(
          absl::StrCat("is \"", name, "\", must be an object or a robot of the world"));
    }
    if (link.empty() || (robot != nullptr && robot->model().FindLink(link).has_value())) continue;
    return item.Field("link").Error(
        robot == nullptr
            ? absl::StrCat("is \"", link, "\", must be empty: \"", name,
                           "\" is an object, which has no links")
            : absl::StrCat("is \"", link, "\", must be a link of robot \"", name, "\""));
  }
  return absl::OkStatus();
}

absl::Status SetPairOptions(const v1::GetDistancesRequest& request, ParsedQueryOptions& options) {
  collision::QueryOptions& query = options.query;
  const FieldPath root;
  switch (request.pairs()) {
    case v1::DISTANCE_PAIRS_UNSPECIFIED:
    case v1::DISTANCE_PAIRS_OBJECTS:
      break;
    case v1::DISTANCE_PAIRS_LINKS:
      query.pairs = collision::DistancePairs::kLinks;
      query.max_results = request.options().max_results();
      if (query.max_results == 0 && !request.options().has_max_distance_m()) {
        const FieldPath of_options = root.Field("options");
        return of_options.Field("max_distance_m")
            .Error(
                "is absent, must be given for DISTANCE_PAIRS_LINKS with max_results 0, which "
                "means all pairs within it");
      }
      break;
    default:
      return root.Field("pairs").Error(absl::StrCat("is ", static_cast<int>(request.pairs()),
                                                    ", must be a known DistancePairs"));
  }
  if (request.want_joint_gradient() && !request.subject().has_robot()) {
    return root.Field("want_joint_gradient")
        .Error("is true, must be false unless the subject is a robot: only robots have joints");
  }
  query.joint_gradients = request.want_joint_gradient();
  return absl::OkStatus();
}

absl::Status SetPairOptions(const v1::GetContactsRequest& request, ParsedQueryOptions& options) {
  const FieldPath root;
  auto status = CheckRange(request.max_contacts_per_pair(), {0, kMaxContactsOfPair},
                           root.Field("max_contacts_per_pair"));
  options.query.max_contacts_per_pair = request.max_contacts_per_pair();
  return status;
}

Limits LimitsOf(const StateQuery& query, const collision::QueryOptions& options, Limits limits) {
  const auto* states = std::get_if<RobotRows>(&query.states);
  if (!options.joint_gradients || states == nullptr) return limits;
  // An answer without a gradient takes about 100 bytes (limits.h), each variable 8 more.
  constexpr std::int64_t kAnswerBytes = 100, kVariableBytes = 8;
  const auto variables = static_cast<std::int64_t>(states->group->variables.size());
  const auto reduced = [&](std::int64_t answers) {
    return answers * kAnswerBytes / (kAnswerBytes + kVariableBytes * variables);
  };
  limits.max_answers = reduced(limits.max_answers);
  limits.max_answers_as_messages = reduced(limits.max_answers_as_messages);
  return limits;
}

absl::Status TooManyLinkPairs(const collision::QueryOptions& options) {
  const FieldPath root;
  const FieldPath of_options = root.Field("options");
  const std::string rule =
      absl::StrCat("more than ", options.max_answers,
                   " answers, which is the most of a batch: ask with fewer rows");
  if (options.max_results > 0) {
    return of_options.Field("max_results")
        .Error(absl::StrCat("is ", options.max_results, " for each link, which makes ", rule));
  }
  return of_options.Field("max_distance_m")
      .Error(absl::StrCat("is ", options.max_distance_m, ", which makes ", rule,
                          " or a smaller distance"));
}

}  // namespace cwm::server
