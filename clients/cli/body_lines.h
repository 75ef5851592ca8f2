// Parses JSON lines that give subjects and rows.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cli/body_arguments.h"

namespace cwm::cli {

// See ReadBodies. `given`: the body from the command line; null: each line names one. Consecutive
// lines of the same body become its rows.
absl::StatusOr<std::vector<Body>> ReadBodyLines(const Body* given, std::istream& in);

// INVALID_ARGUMENT with `name` if the row's width differs from that of previous rows.
absl::Status AppendRow(const std::vector<double>& row, const std::string& name, Body& body);

}  // namespace cwm::cli
