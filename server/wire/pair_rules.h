// Converts pair rules from requests and to replies and events.
#pragma once

#include "absl/status/statusor.h"
#include "collision/world/world_snapshot.h"
#include "cwm/v1/world.pb.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// The named objects and robots need not exist: a rule may concern future ones.
absl::StatusOr<collision::NamedPair> NamedPairFromProto(const v1::NamedPair& pair,
                                                        const FieldPath& path);

// The rule expires at the present wall-clock time plus the request's duration, which must be
// positive and at most a year.
absl::StatusOr<collision::AllowCollision> AllowCollisionFromProto(const v1::AllowCollision& allow,
                                                                  const FieldPath& path);
absl::StatusOr<collision::SetPairMargin> SetPairMarginFromProto(const v1::SetPairMargin& set,
                                                                const FieldPath& path);

v1::PairRule PairRuleToProto(const collision::PairRule& rule);

}  // namespace cwm::server
