// Errors of changes that name the faulty field, as payloads of their status. Readers use FaultOf in
// world_snapshot.h.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace cwm::collision {

struct FieldRule {
  std::string field;
  std::string rule;  // the rule that the field violates
};

// INVALID_ARGUMENT "FIELD RULE". Neither may contain a line break.
absl::Status InvalidFieldError(std::string_view field, std::string_view rule);
// Adds the field to another error.
absl::Status WithField(std::string_view field, absl::Status status);
// The payload of InvalidFieldError and WithField; empty for other statuses.
std::optional<FieldRule> FieldRuleOf(const absl::Status& status);

// Turns the error of one change into the error of its list.
absl::Status WithChangeIndex(std::size_t index, const absl::Status& status);

// Errors that changes of objects and robots share.
absl::Status RobotNotFoundError(const std::string& name);
absl::Status InvalidNameError(std::string_view name);
absl::Status InvalidPoseError(std::string_view field);

}  // namespace cwm::collision
