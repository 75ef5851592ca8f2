// Reads what a query about pairs says beyond its subject: the named members to which it is
// restricted, and the pairs that are answered.
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "collision/world/world_snapshot.h"
#include "cwm/v1/query.pb.h"
#include "server/core/limits.h"
#include "server/wire/field_path.h"
#include "server/wire/queries.h"

namespace cwm::server {

// QueryOptions.only without what depends on the world: refuses "*" and too many names.
absl::StatusOr<std::vector<collision::NamedThing>> NamedThingsFromProto(
    const google::protobuf::RepeatedPtrField<v1::NamedThing>& only, const FieldPath& path);
// Refuses names and links that the world does not have; otherwise a mistake in a name would let a
// query find nothing.
absl::Status CheckNamedThings(const std::vector<collision::NamedThing>& only,
                              const collision::WorldSnapshot& snapshot, const FieldPath& path);

// Sets the options that a request has besides QueryOptions.
absl::Status SetPairOptions(const v1::GetDistancesRequest& request, ParsedQueryOptions& options);
absl::Status SetPairOptions(const v1::GetContactsRequest& request, ParsedQueryOptions& options);
inline absl::Status SetPairOptions(const v1::CheckCollisionsRequest&, ParsedQueryOptions&) {
  return absl::OkStatus();
}

// The limits for a batch about the query, whose answers may have joint gradients.
Limits LimitsOf(const StateQuery& query, const collision::QueryOptions& options, Limits limits);

// The error of more answers than QueryOptions::max_answers, for DISTANCE_PAIRS_LINKS.
absl::Status TooManyLinkPairs(const collision::QueryOptions& options);

}  // namespace cwm::server
