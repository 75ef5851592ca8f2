// Finds the world and the snapshot that a read is about. A read waits for a revision that is not
// made yet before its work begins, so that no worker thread ever waits.
#pragma once

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "cwm/v1/world.pb.h"
#include "server/rpc/call.h"

namespace cwm::server {

// The revision that AtRevision.at_least has to wait for; empty for other rules and for a negative
// revision, which the work refuses with the field's name. The errors of WorldRegistry::Find.
absl::StatusOr<std::optional<RevisionToAwait>> FindRevisionToAwait(const Runtime& runtime,
                                                                   const std::string& world,
                                                                   const std::string& world_uid,
                                                                   const v1::AtRevision& rule);

// The world and its snapshot. Never waits: a revision that the call awaited is in `call.reached`.
// The errors of WorldRegistry::Find and World::At.
absl::StatusOr<WorldAtRevision> FindWorldAt(const Runtime& runtime, const std::string& world,
                                            const std::string& world_uid, const RevisionRule& rule,
                                            const CallContext& call);

}  // namespace cwm::server
