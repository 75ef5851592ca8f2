// Rules of pairs as requests make them and replies and events show them.
#pragma once

#include "absl/status/statusor.h"
#include "collision/world/world_snapshot.h"
#include "cwm/v1/world.pb.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// Whether there are such things is nobody's concern: a rule may be of what is yet to come.
absl::StatusOr<collision::NamedPair> FromProto(const v1::NamedPair& pair, const FieldPath& path);

// Expires at the wall clock's time now and what the request gives it, which is positive and at most
// a year.
absl::StatusOr<collision::AllowCollision> FromProto(const v1::AllowCollision& allow,
                                                    const FieldPath& path);
absl::StatusOr<collision::SetPairMargin> FromProto(const v1::SetPairMargin& set,
                                                   const FieldPath& path);

v1::PairRule ToProto(const collision::PairRule& rule);

}  // namespace cwm::server
