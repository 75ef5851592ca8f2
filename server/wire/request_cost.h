// The time that a request will take, estimated before any of it is done: for queues that are fair,
// for limits and for advice when to come again.
#pragma once

#include "absl/status/status.h"
#include "collision/world/world_snapshot.h"
#include "cwm/v1/query.pb.h"
#include "cwm/v1/world.pb.h"
#include "server/core/geometry_store.h"
#include "server/core/limits.h"

namespace cwm::server {

// What an estimate looks up: counts of triangles and parts, never geometry.
struct CostSource {
  const GeometryStore& store;
  const collision::WorldSnapshot* snapshot = nullptr;  // that is asked; nullptr: no such world
};

// CPU seconds of one core, right to a factor of about three where objects are spread out, more
// where everything is near everything: a bound of what is likely, not of what is possible. Takes a
// few microseconds and some hundred nanoseconds for each shape that the request brings, of which no
// more than some thousand are looked at.
double EstimatedCost_s(const v1::CheckCollisionsRequest& request, const CostSource& source);
double EstimatedCost_s(const v1::GetDistancesRequest& request, const CostSource& source);
double EstimatedCost_s(const v1::GetContactsRequest& request, const CostSource& source);
double EstimatedCost_s(const v1::CheckMotionsRequest& request, const CostSource& source);
double EstimatedCost_s(const v1::CastRaysRequest& request, const CostSource& source);
double EstimatedCost_s(const v1::SamplePointsRequest& request, const CostSource& source);
// Of its overlay and its question.
double EstimatedCost_s(const v1::StreamQueriesRequest& request, const CostSource& source);
double EstimatedCost_s(const v1::ApplyChangesRequest& request, const CostSource& source);
// Of storing so many bytes: hashed, decoded, checked.
double CostOfGeometry_s(std::int64_t bytes);

// RESOURCE_EXHAUSTED REQUEST_TOO_COSTLY above limits.max_request_cost_s, with the estimate and the
// limit: such a request has to be split, not repeated.
absl::Status CheckCost(double cost_s, const Limits& limits);

}  // namespace cwm::server
