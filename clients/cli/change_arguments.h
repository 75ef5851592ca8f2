// Options of every command that changes the world.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/cli/session.h"
#include "cwm/v1/world.pb.h"

namespace cwm::cli {

struct ChangeArguments {
  std::optional<std::int64_t> expected_revision;
  std::string request_id;
};

void AddChangeOptions(CLI::App& command, ChangeArguments& change);

// Applies the changes, all or none, and prints the revision; `done` is the first line of the table.
absl::Status Apply(Session& session, const ChangeArguments& arguments,
                   const std::vector<cwm::v1::Change>& changes, const std::string& done);

}  // namespace cwm::cli
