// Refusals of changes that know which field they are about, as payloads of their status; what
// readers of them need is in world_snapshot.h (FaultOf).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace cwm::collision {

struct FieldRule {
  std::string field;
  std::string rule;  // what the field breaks
};

// INVALID_ARGUMENT "FIELD RULE". Neither holds a line break.
absl::Status BadField(std::string_view field, std::string_view rule);
// Another refusal that knows its field.
absl::Status InField(std::string_view field, absl::Status status);
// Of the two; nothing for other statuses.
std::optional<FieldRule> FieldRuleOf(const absl::Status& status);

// The refusal of one change as the refusal of its list.
absl::Status AtChange(std::size_t index, const absl::Status& status);

// The refusals that changes of objects and robots share.
absl::Status MissingRobot(const std::string& name);
absl::Status BadName(std::string_view name);
absl::Status BadPose(std::string_view field);

}  // namespace cwm::collision
