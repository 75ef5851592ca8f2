// Pairs of things on the command line: an object or a robot by its name, a link as ROBOT:LINK, and
// "*" for everything. No name has a colon, so the first one ends it.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "cwm/v1/world.pb.h"

namespace cwm::cli {

// A usage error that names `option` for an empty name or link, and for a link of everything.
absl::StatusOr<cwm::v1::NamedThing> ParseThing(const std::string& text, const std::string& option);
// "A,B". Of a link that has a comma in its name only `cwm allow` and `cwm margin` can speak.
absl::StatusOr<cwm::v1::NamedPair> ParsePair(const std::string& text, const std::string& option);

// As ParseThing reads it.
std::string ThingText(const cwm::v1::NamedThing& thing);
// "allowed until 2026-11-22 14:08:12 UTC, margin 20.0 mm"; "no rule" for one that says nothing.
std::string RuleText(const cwm::v1::PairRule& rule);

}  // namespace cwm::cli
