// JSON lines that say what asks and where.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cli/body_arguments.h"

namespace cwm::cli {

// See ReadBodies. `given`: the body that the command line named; null: each line names one. Lines
// of the same body follow each other as its rows.
absl::StatusOr<std::vector<Body>> ReadBodyLines(const Body* given, std::istream& in);

// INVALID_ARGUMENT naming `name` when the row has another width than those before.
absl::Status AppendRow(const std::vector<double>& row, const std::string& name, Body& body);

}  // namespace cwm::cli
