// cwm contacts --all
#pragma once

#include "absl/status/status.h"
#include "clients/cli/query_arguments.h"

namespace cwm::cli {

// Asks for all contacts between objects and robots of the world and prints them, deepest first.
absl::Status PrintWorldContacts(Session& session, const QueryArguments& query);

}  // namespace cwm::cli
