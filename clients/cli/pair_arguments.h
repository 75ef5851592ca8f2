// Pairs on the command line. A member of a pair is an object or a robot by its name, a link as
// ROBOT:LINK, or "*" for everything. No name contains a colon, so the first one separates the link.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "cwm/v1/world.pb.h"

namespace cwm::cli {

// A usage error with `option` for an empty name or link, and for a link of "*".
absl::StatusOr<cwm::v1::NamedThing> ParsePairMember(const std::string& text,
                                                    const std::string& option);
// Parses "A,B". Links with a comma in their name can only be given to `cwm allow` and `cwm margin`.
absl::StatusOr<cwm::v1::NamedPair> ParsePair(const std::string& text, const std::string& option);

// The form that ParsePairMember reads.
std::string PairMemberText(const cwm::v1::NamedThing& member);
// "allowed until 2026-11-22 14:08:12 UTC, margin 20.0 mm"; "checked"; "no rule" for an empty rule.
std::string FormatRule(const cwm::v1::PairRule& rule);

}  // namespace cwm::cli
