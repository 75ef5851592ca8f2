#include "server/core/refusal.h"

#include <string>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

using collision::Change;
using collision::Revision;

// The path of the field at fault in the request that holds the list.
std::string FieldOf(const Change& change, const collision::ApplyFault& fault,
                    const std::string& list) {
  std::string place = absl::StrCat(list, "[", fault.change, "]");
  if (fault.field != "expected_object_revision") {
    if (std::holds_alternative<collision::SetRobotState>(change.what)) place += ".robot_state";
    if (std::holds_alternative<collision::AttachObject>(change.what)) place += ".attach";
    if (std::holds_alternative<collision::AllowCollision>(change.what)) place += ".allow";
    if (std::holds_alternative<collision::SetPairMargin>(change.what)) place += ".margin";
  }
  return fault.field.empty() ? place : absl::StrCat(place, ".", fault.field);
}

}  // namespace

absl::Status ExplainRefusal(const absl::Status& status, const collision::WorldSnapshot& base,
                            std::span<const Change> changes, const std::string& list) {
  const std::optional<collision::ApplyFault> fault = collision::FaultOf(status);
  const Change* change = fault.has_value() ? &changes[fault->change] : nullptr;
  const bool is_of_robot = change != nullptr && IsRobotChange(*change);
  ErrorDetails details;
  if (change != nullptr) {
    details.metadata["change_index"] = std::to_string(fault->change);
    if (!IsPairRuleChange(*change)) {
      details.metadata[is_of_robot ? "robot" : "object"] = NameOf(*change);
    }
    if (const auto* attach = std::get_if<collision::AttachObject>(&change->what)) {
      details.metadata["robot"] = attach->robot;
    }
  }
  if (status.code() == absl::StatusCode::kNotFound) {
    const bool no_robot = change != nullptr && IsUnknownRobotFault(*change, *fault);
    details.reason = no_robot ? "ROBOT_UNKNOWN" : "OBJECT_UNKNOWN";
  } else if (status.code() == absl::StatusCode::kAborted) {
    details.reason = "OBJECT_REVISION_MISMATCH";
    if (change != nullptr && change->expected_object_revision.has_value()) {
      details.metadata["expected_revision"] =
          std::to_string(change->expected_object_revision->value);
      const std::optional<Revision> actual = LatestRevisionOf(base, *change);
      if (actual.has_value()) {  // empty: there is no such object
        details.metadata["actual_revision"] = std::to_string(actual->value);
      }
    }
  } else if (status.code() == absl::StatusCode::kResourceExhausted) {
    details.reason = "TOO_MANY_PAIR_RULES";
    details.metadata["limit"] = std::to_string(collision::kMaxPairRules);
  } else {
    details.reason = "INVALID_FIELD";
    if (fault.has_value()) details.fields.push_back({FieldOf(*change, *fault, list), fault->rule});
  }
  std::string message(status.message());
  if (fault.has_value()) {  // the message begins with an index into "changes", which the request
                            // may call differently
    message = absl::StrCat(list, message.substr(message.find('[')));
  }
  return MakeError(status.code(), std::move(message), std::move(details));
}

}  // namespace cwm::server
