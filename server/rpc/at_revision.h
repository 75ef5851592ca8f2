// Which world and which snapshot a read is about, and how it waits for one that is not made yet:
// before its work begins, so that no worker ever waits.
#pragma once

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "cwm/v1/world.pb.h"
#include "server/rpc/call.h"

namespace cwm::server {

// What AtRevision.at_least has to wait for; nothing for other rules and for a negative revision,
// which the work refuses by its field. The errors of WorldRegistry::Find.
absl::StatusOr<std::optional<RevisionToAwait>> WhatToAwait(const Runtime& runtime,
                                                           const std::string& world,
                                                           const std::string& world_uid,
                                                           const v1::AtRevision& rule);

// The world and its snapshot. Never waits: what the call awaited is in `call.reached`. The errors
// of WorldRegistry::Find and World::At.
absl::StatusOr<WorldAtRevision> FindWorldAt(const Runtime& runtime, const std::string& world,
                                            const std::string& world_uid, const RevisionRule& rule,
                                            const CallContext& call);

}  // namespace cwm::server
