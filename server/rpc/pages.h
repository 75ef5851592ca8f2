// Lists in pages that all show one revision: where a page begins, and the token of the next.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "cwm/v1/world.pb.h"
#include "server/rpc/call.h"

namespace cwm::server {

// The default receive limit of gRPC's clients is 4 MiB; one large member may still follow.
inline constexpr std::size_t kPageBytes = 2 << 20;

// What a list request says of its pages.
struct PageQuery {
  const std::string& world;
  const std::string& world_uid;
  const v1::AtRevision& at_revision;
  const std::string& page_token;
  std::string filter;  // a token is bound to it: all else that the request says
};

// What the page shows: the revision of the token, if there is one.
struct PageSource {
  WorldAtRevision at;
  std::string digest;  // of world and filter
  std::string after;   // name of the last member that was sent
};

// A token of another world or filter is INVALID_FIELD, and OUT_OF_RANGE REVISION_COMPACTED once its
// revision is no longer kept. The errors of FindWorldAt.
absl::StatusOr<PageSource> FindPage(const Runtime& runtime, const PageQuery& query,
                                    const CallContext& call);

// How many members a page may have: the default for 0. INVALID_FIELD beyond the largest.
absl::StatusOr<std::size_t> PageSizeOf(std::int32_t page_size);

// The token of the page after the member of that name.
std::string NextToken(const PageSource& source, const std::string& last);

}  // namespace cwm::server
