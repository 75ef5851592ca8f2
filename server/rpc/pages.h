// Lists in pages that all show the same revision: the start of a page, and the token of the next.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "cwm/v1/world.pb.h"
#include "server/rpc/call.h"

namespace cwm::server {

// chosen: gRPC clients receive at most 4 MiB by default, and one large member may still follow.
inline constexpr std::size_t kPageBytes = 2 << 20;

// The paging fields of a list request.
struct PageQuery {
  const std::string& world;
  const std::string& world_uid;
  const v1::AtRevision& at_revision;
  const std::string& page_token;
  std::string filter;  // all other fields of the request, which a token is bound to
};

// The source of a page: the revision of the token if there is one.
struct PageSource {
  WorldAtRevision at;
  std::string digest;  // of the world's uid and the filter
  std::string after;   // name of the last member sent
};

// INVALID_FIELD for a token of another world or filter, OUT_OF_RANGE REVISION_COMPACTED once its
// revision is no longer kept. The errors of FindWorldAt.
absl::StatusOr<PageSource> FindPage(const Runtime& runtime, const PageQuery& query,
                                    const CallContext& call);

// The most members of a page; the default for 0. INVALID_FIELD above the limit.
absl::StatusOr<std::size_t> PageSizeOf(std::int32_t page_size);

// The token of the page that follows the member named `last`.
std::string NextToken(const PageSource& source, const std::string& last);

}  // namespace cwm::server
