#include "server/rpc/pages.h"

#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "proto/transfer/sha256.h"
#include "server/rpc/at_revision.h"
#include "server/wire/numbers.h"
#include "server/wire/queries.h"

namespace cwm::server {
namespace {

constexpr int kDefaultPageSize = 1'000;
constexpr int kMaxPageSize = 10'000;

struct Position {
  collision::Revision revision;
  std::string after;  // name of the last member sent
};

std::string DigestOf(const std::string& filter, const World& world) {
  constexpr std::size_t kDigestChars = 16;
  return Sha256Hex(absl::StrCat(world.uid(), "\n", filter)).substr(0, kDigestChars);
}

absl::StatusOr<Position> ReadToken(const std::string& token, const std::string& digest) {
  const absl::Status foreign = FieldPath::OfRequest("page_token")
                                   .Error("must be next_page_token of the same world and filter");
  std::string text;
  if (!absl::WebSafeBase64Unescape(token, &text)) return foreign;
  const std::size_t first = text.find(' ');
  const std::size_t second = first == std::string::npos ? first : text.find(' ', first + 1);
  if (second == std::string::npos || text.substr(0, first) != digest) return foreign;
  Position position;
  if (!absl::SimpleAtoi(text.substr(first + 1, second - first - 1), &position.revision.value)) {
    return foreign;
  }
  position.after = text.substr(second + 1);
  return position;
}

}  // namespace

absl::StatusOr<PageSource> FindPage(const Runtime& runtime, const PageQuery& query,
                                    const CallContext& call) {
  constexpr std::int64_t kMaxTokenBytes = 1024;  // issued tokens have less than half of it
  const FieldPath root;
  if (auto status = CheckTextLength(query.page_token, kMaxTokenBytes, root.Field("page_token"));
      !status.ok()) {
    return status;
  }
  auto rule = RevisionRuleFromProto(query.at_revision, FieldPath::OfRequest("at_revision"));
  if (!rule.ok()) return rule.status();
  auto world = runtime.application.worlds.Find(query.world, query.world_uid);
  if (!world.ok()) return world.status();
  PageSource source{.at = {}, .digest = DigestOf(query.filter, **world), .after = {}};
  if (!query.page_token.empty()) {
    auto position = ReadToken(query.page_token, source.digest);
    if (!position.ok()) return position.status();
    *rule = Exactly{position->revision};
    source.after = std::move(position->after);
  }
  auto at = FindWorldAt(runtime, query.world, query.world_uid, *rule, call);
  if (!at.ok()) return at.status();
  source.at = *std::move(at);
  return source;
}

absl::StatusOr<std::size_t> PageSizeOf(std::int32_t page_size) {
  const FieldPath root;
  auto status = CheckRange(page_size, {0, kMaxPageSize}, root.Field("page_size"));
  if (!status.ok()) return status;
  return static_cast<std::size_t>(page_size == 0 ? kDefaultPageSize : page_size);
}

// Digest, revision and name, encoded in characters that are safe on a command line.
std::string NextToken(const PageSource& source, const std::string& last) {
  const std::int64_t revision = source.at.snapshot->revision().value;
  return absl::WebSafeBase64Escape(absl::StrCat(source.digest, " ", revision, " ", last));
}

}  // namespace cwm::server
