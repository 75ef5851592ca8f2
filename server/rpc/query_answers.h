// Turns a query message into its answer message, for unary calls and streams: one snapshot, one
// batch.
#pragma once

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "cwm/v1/query.pb.h"
#include "cwm/v1/robot.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/stream_overlay.h"

namespace cwm::server {

// The state that a stream keeps between queries.
struct StreamMemory {
  // The snapshot that it answered from last: it can be queried by its exact revision while the
  // stream lives, even after the world has dropped it.
  std::string world_uid;
  SnapshotPtr snapshot;
  StreamOverlay overlay;
};

// `memory` is null for unary calls. After an error the response is unspecified.
absl::Status AnswerQuery(Runtime& runtime, const v1::CheckCollisionsRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::CheckCollisionsResponse* response);
absl::Status AnswerQuery(Runtime& runtime, const v1::GetDistancesRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::GetDistancesResponse* response);
absl::Status AnswerQuery(Runtime& runtime, const v1::GetContactsRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::GetContactsResponse* response);
absl::Status AnswerQuery(Runtime& runtime, const v1::GetWorldContactsRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::GetWorldContactsResponse* response);
absl::Status AnswerQuery(Runtime& runtime, const v1::CheckMotionsRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::CheckMotionsResponse* response);
absl::Status AnswerQuery(Runtime& runtime, const v1::SolvePosesRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::SolvePosesResponse* response);
absl::Status AnswerQuery(Runtime& runtime, const v1::GetLinkPosesRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::GetLinkPosesResponse* response);
absl::Status AnswerQuery(Runtime& runtime, const v1::CastRaysRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::CastRaysResponse* response);
absl::Status AnswerQuery(Runtime& runtime, const v1::SamplePointsRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::SamplePointsResponse* response);

}  // namespace cwm::server
