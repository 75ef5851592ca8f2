// Lists objects in pages that all show the same revision.
#pragma once

#include "absl/status/status.h"
#include "cwm/v1/world.pb.h"
#include "server/rpc/call.h"

namespace cwm::server {

// The objects after the token's position that pass the filter, until the page is full by count or
// bytes. The token of the next page is bound to world, revision and filter: INVALID_FIELD with
// another one, OUT_OF_RANGE REVISION_COMPACTED once its revision is no longer kept.
absl::Status ListPage(Runtime& runtime, const v1::ListObjectsRequest& request,
                      const CallContext& call, v1::ListObjectsResponse* response);

}  // namespace cwm::server
