// Lists of objects in pages that all show one revision.
#pragma once

#include "absl/status/status.h"
#include "cwm/v1/world.pb.h"
#include "server/rpc/call.h"

namespace cwm::server {

// Objects after the token's, filtered, until the page is full by count or by bytes. The token of
// the next page is bound to world, revision and filter: with another one it is INVALID_FIELD, and
// OUT_OF_RANGE REVISION_COMPACTED once its revision is no longer kept.
absl::Status ListPage(Runtime& runtime, const v1::ListObjectsRequest& request,
                      const CallContext& call, v1::ListObjectsResponse* response);

}  // namespace cwm::server
