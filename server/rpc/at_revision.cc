#include "server/rpc/at_revision.h"

#include <utility>
#include <variant>

namespace cwm::server {

absl::StatusOr<std::optional<RevisionToAwait>> FindRevisionToAwait(const Runtime& runtime,
                                                                   const std::string& world,
                                                                   const std::string& world_uid,
                                                                   const v1::AtRevision& rule) {
  if (!rule.has_at_least() || rule.at_least() < 0) return std::nullopt;
  auto found = runtime.application.worlds.Find(world, world_uid);
  if (!found.ok()) return found.status();
  return RevisionToAwait{*std::move(found), collision::Revision{rule.at_least()}};
}

absl::StatusOr<WorldAtRevision> FindWorldAt(const Runtime& runtime, const std::string& world,
                                            const std::string& world_uid, const RevisionRule& rule,
                                            const CallContext& call) {
  if (std::holds_alternative<AtLeast>(rule) && call.reached.has_value()) return *call.reached;
  auto found = runtime.application.worlds.Find(world, world_uid);
  if (!found.ok()) return found.status();
  auto snapshot = (*found)->At(rule, Clock::now(), call.stop);
  if (!snapshot.ok()) return snapshot.status();
  return WorldAtRevision{*std::move(found), *std::move(snapshot)};
}

}  // namespace cwm::server
