// From a question on the wire to its answer on the wire, for the unary calls and for the stream:
// one snapshot, one batch.
#pragma once

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "cwm/v1/query.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/stream_overlay.h"

namespace cwm::server {

// What a stream keeps from one question to the next.
struct StreamMemory {
  // The snapshot that it answered from last: it stays askable by its exact revision while the
  // stream lives, even when the world no longer keeps it.
  std::string world_uid;
  SnapshotPtr snapshot;
  StreamOverlay overlay;
};

// `memory` is null of unary calls. Errors leave the response in an unspecified state.
absl::Status Answer(Runtime& runtime, const v1::CheckCollisionsRequest& request,
                    const CallContext& call, StreamMemory* memory,
                    v1::CheckCollisionsResponse* response);
absl::Status Answer(Runtime& runtime, const v1::GetDistancesRequest& request,
                    const CallContext& call, StreamMemory* memory,
                    v1::GetDistancesResponse* response);
absl::Status Answer(Runtime& runtime, const v1::GetContactsRequest& request,
                    const CallContext& call, StreamMemory* memory,
                    v1::GetContactsResponse* response);
absl::Status Answer(Runtime& runtime, const v1::CheckMotionsRequest& request,
                    const CallContext& call, StreamMemory* memory,
                    v1::CheckMotionsResponse* response);
absl::Status Answer(Runtime& runtime, const v1::CastRaysRequest& request, const CallContext& call,
                    StreamMemory* memory, v1::CastRaysResponse* response);
absl::Status Answer(Runtime& runtime, const v1::SamplePointsRequest& request,
                    const CallContext& call, StreamMemory* memory,
                    v1::SamplePointsResponse* response);

}  // namespace cwm::server
