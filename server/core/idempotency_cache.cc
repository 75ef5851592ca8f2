#include "server/core/idempotency_cache.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/core/approximate_bytes.h"
#include "server/core/error.h"
#include "server/core/ingest.h"

namespace cwm::server {
namespace {

// chosen: a UUID has 36 characters; room for four of them, or for prefixes.
constexpr std::size_t kMaxRequestIdBytes = 128;
// chosen: ids are freed one by one as they age, hundreds in a second at the rate that fills the
// memory.
constexpr double kInProgressRetry_s = 1;

// derived: a record of 80 bytes, its id of 36, the table's node and two pointers, as the allocator
// rounds them.
constexpr std::int64_t kRecordBytes = 220;

std::int64_t BytesOf(const IngestOutcome& outcome) {
  std::int64_t bytes = static_cast<std::int64_t>(sizeof(outcome)) +
                       static_cast<std::int64_t>(outcome.labels.size() * sizeof(std::uint32_t));
  // Counted, since the reply may hold objects that the world no longer holds.
  for (const auto& support : outcome.supports) bytes += ApproximateBytes(*support);
  for (const auto& object : outcome.objects) bytes += ApproximateBytes(*object);
  return bytes;
}

absl::Status ReusedForOtherContent(const std::string& id) {
  return MakeError(absl::StatusCode::kFailedPrecondition,
                   absl::StrCat("request_id: \"", id, "\" was used before for other content"),
                   {.reason = "REQUEST_ID_REUSED", .metadata = {{"request_id", id}}});
}

absl::Status ReplyCompacted(const std::string& id, collision::Revision revision) {
  return MakeError(
      absl::StatusCode::kOutOfRange,
      absl::StrCat("request_id: \"", id, "\" was ingested at revision ", revision.value,
                   ", its reply is no longer kept"),
      {.reason = "REPLY_COMPACTED",
       .metadata = {{"request_id", id}, {"revision", std::to_string(revision.value)}}});
}

absl::Status Exhausted(std::int64_t limit) {
  return MakeError(absl::StatusCode::kResourceExhausted,
                   absl::StrCat("request_id: ", limit, " are remembered, must be at most ", limit),
                   {.reason = "REQUEST_IDS_EXHAUSTED",
                    .metadata = {{"limit", std::to_string(limit)}},
                    .retry_after_s = kInProgressRetry_s});
}

}  // namespace

absl::StatusOr<std::optional<WriteOutcome>> IdempotencyCache::Find(const WriteOptions& options,
                                                                   Clock::time_point now) {
  const std::string& id = options.request_id;
  if (id.empty()) return std::nullopt;
  if (id.size() > kMaxRequestIdBytes) {
    return InvalidField(
        "request_id",
        absl::StrCat("has ", id.size(), " characters, must have at most ", kMaxRequestIdBytes));
  }
  Expire(now);
  const auto found = records_.find(id);
  if (found == records_.end()) {
    if (static_cast<std::int64_t>(records_.size()) >= retention_.request_ids) {
      return Exhausted(retention_.request_ids);
    }
    return std::nullopt;
  }
  const Record& record = found->second;
  if (record.digest != Shortened(options.request_digest)) return ReusedForOtherContent(id);
  if (record.was_ingest && record.reply == nullptr) return ReplyCompacted(id, record.revision);
  return WriteOutcome{.revision = record.revision, .replayed = true, .ingest = record.reply};
}

IdempotencyCache::ShortDigest IdempotencyCache::Shortened(const std::string& digest) {
  ShortDigest first = {};
  std::copy_n(digest.begin(), std::min(digest.size(), first.size()), first.begin());
  return first;
}

void IdempotencyCache::Insert(const WriteOptions& options, const WriteOutcome& outcome,
                              std::shared_ptr<const IngestOutcome> reply,
                              Clock::time_point now) noexcept {
  if (options.request_id.empty()) return;
  const std::int64_t reply_bytes = reply != nullptr ? BytesOf(*reply) : 0;
  const std::string& id = Add(options.request_id, {.digest = Shortened(options.request_digest),
                                                   .revision = outcome.revision,
                                                   .when = now,
                                                   .was_ingest = reply != nullptr,
                                                   .reply = std::move(reply),
                                                   .reply_bytes = reply_bytes});
  reply_bytes_ += reply_bytes;
  if (reply_bytes > 0) replies_by_age_.push_back(&id);
  while (reply_bytes_ > retention_.reply_bytes && !replies_by_age_.empty()) {
    DropReply(records_.at(*replies_by_age_.front()));
    replies_by_age_.pop_front();
  }
  charge_.ForceResize(Bytes());
}

void IdempotencyCache::Restore(const WorldImage::Request& request) {
  Add(request.request.id, {.digest = Shortened(request.request.digest),
                           .revision = request.revision,
                           .when = request.when,
                           .was_ingest = request.request.is_ingest,
                           .reply = nullptr,
                           .reply_bytes = 0});
  charge_.ForceResize(Bytes());
}

const std::string& IdempotencyCache::Add(const std::string& id, Record record) {
  const auto [added, is_new] = records_.insert_or_assign(id, std::move(record));
  if (is_new) by_age_.push_back(&added->first);
  return added->first;
}

void IdempotencyCache::TakeBack(const std::string& request_id) {
  const auto found = records_.find(request_id);
  if (found == records_.end() || by_age_.back() != &found->first) return;
  if (!replies_by_age_.empty() && replies_by_age_.back() == &found->first) {
    DropReply(found->second);
    replies_by_age_.pop_back();
  }
  by_age_.pop_back();
  records_.erase(found);
  charge_.ForceResize(Bytes());
}

std::int64_t IdempotencyCache::Bytes() const {
  return kRecordBytes * static_cast<std::int64_t>(records_.size()) + reply_bytes_;
}

void IdempotencyCache::Expire(Clock::time_point now) {
  while (!by_age_.empty()) {
    const auto oldest = records_.find(*by_age_.front());
    if (oldest->second.when + retention_.request_id_time >= now) return;
    if (!replies_by_age_.empty() && replies_by_age_.front() == by_age_.front()) {
      DropReply(oldest->second);
      replies_by_age_.pop_front();
    }
    by_age_.pop_front();
    records_.erase(oldest);
  }
}

void IdempotencyCache::DropReply(Record& record) {
  reply_bytes_ -= record.reply_bytes;
  record.reply_bytes = 0;
  record.reply = nullptr;
}

}  // namespace cwm::server
