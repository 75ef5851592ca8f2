// Errors of what was read from a store.
#pragma once

#include <string_view>

#include "absl/status/status.h"

namespace cwm::server {

// A value that breaks a rule, by the name of its field: DataLoss "FIELD: RULE".
absl::Status Broken(std::string_view field, std::string_view rule);
// Names the message in which the broken field is: "OUTER.FIELD: RULE". Keeps the code.
absl::Status Within(std::string_view outer, const absl::Status& status);

// DataLoss STORE_DAMAGED, "the store is damaged: PLACE: WHAT".
absl::Status Damaged(std::string_view place, std::string_view what);
// The same for a broken field of the place. Other errors than DataLoss stay as they are.
absl::Status DamagedAt(std::string_view place, const absl::Status& status);

}  // namespace cwm::server
