// Estimates the time that a request will take before any work is done: for fair queues, for limits
// and for the suggested time of a retry.
#pragma once

#include "absl/status/status.h"
#include "collision/world/world_snapshot.h"
#include "cwm/v1/query.pb.h"
#include "cwm/v1/robot.pb.h"
#include "cwm/v1/world.pb.h"
#include "server/core/geometry_store.h"
#include "server/core/limits.h"

namespace cwm::server {

// The sources of an estimate: only counts of triangles and parts are looked up, never geometry.
struct CostSource {
  const GeometryStore& store;
  const collision::WorldSnapshot* snapshot = nullptr;  // nullptr: no such world
};

// CPU seconds of one core, right within a factor of about three if objects are spread out, and less
// accurate if everything is near everything: a bound of what is likely, not of what is possible.
// Takes a few microseconds, and some hundred nanoseconds for each shape in the request, of which at
// most some thousand are examined.
double EstimatedCost_s(const v1::CheckCollisionsRequest& request, const CostSource& source);
double EstimatedCost_s(const v1::GetDistancesRequest& request, const CostSource& source);
double EstimatedCost_s(const v1::GetContactsRequest& request, const CostSource& source);
double EstimatedCost_s(const v1::GetWorldContactsRequest& request, const CostSource& source);
double EstimatedCost_s(const v1::CheckMotionsRequest& request, const CostSource& source);
double EstimatedCost_s(const v1::SolvePosesRequest& request, const CostSource& source);
double EstimatedCost_s(const v1::GetLinkPosesRequest& request, const CostSource& source);
double EstimatedCost_s(const v1::CastRaysRequest& request, const CostSource& source);
double EstimatedCost_s(const v1::SamplePointsRequest& request, const CostSource& source);
// The cost of the overlay and the query.
double EstimatedCost_s(const v1::StreamQueriesRequest& request, const CostSource& source);
double EstimatedCost_s(const v1::ApplyChangesRequest& request, const CostSource& source);
// The cost of storing `bytes` bytes: hashing, decoding, checking.
double GeometryCost_s(std::int64_t bytes);

// RESOURCE_EXHAUSTED REQUEST_TOO_COSTLY above limits.max_request_cost_s, with the estimate and the
// limit: such a request must be split, not repeated.
absl::Status CheckCost(double cost_s, const Limits& limits);

}  // namespace cwm::server
