// Remembers which writes were made under which request_id, so that a retry gets the first reply and
// changes nothing. Not thread safe: used under the writer's turn.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/core/limits.h"
#include "server/core/memory_budget.h"
#include "server/core/world.h"

namespace cwm::server {

class IdempotencyCache {
 public:
  // `charge` is kept equal to the bytes of the records.
  explicit IdempotencyCache(Retention retention, MemoryCharge charge = {})
      : retention_(retention), charge_(std::move(charge)) {}

  // The first reply if the options' request_id was used before; empty if the id is new or empty.
  // FailedPrecondition REQUEST_ID_REUSED if it was used for other content; OutOfRange
  // REPLY_COMPACTED if it was an ingest whose reply is no longer kept (metadata: revision);
  // ResourceExhausted REQUEST_IDS_EXHAUSTED if no more ids can be remembered; InvalidArgument for
  // an id that is too long.
  absl::StatusOr<std::optional<WriteOutcome>> Find(const WriteOptions& options,
                                                   Clock::time_point now);

  // Records a write that succeeded, with or without effect. Does nothing for an empty request_id. A
  // lack of memory ends the process, since a retry would be told of a write that was not made.
  void Insert(const WriteOptions& options, const WriteOutcome& outcome,
              std::shared_ptr<const IngestOutcome> reply, Clock::time_point now) noexcept;
  // Records a write of before a restart; the whole reply to an ingest is not kept. In order of age.
  void Restore(const WorldImage::Request& request);
  // Forgets a write that was rolled back. Of several, the newest must be forgotten first.
  void TakeBack(const std::string& request_id);

 private:
  // The first 128 bits of a digest in hex, which tell requests apart as well as all of them.
  using ShortDigest = std::array<char, 32>;
  static ShortDigest Shortened(const std::string& digest);

  // One for each write of the last minutes: small, since there may be a million.
  struct Record {
    ShortDigest digest = {};
    collision::Revision revision;
    Clock::time_point when;
    bool was_ingest = false;
    std::shared_ptr<const IngestOutcome> reply;  // nullptr once dropped
    std::int64_t reply_bytes = 0;
  };

  const std::string& Add(const std::string& id, Record record);  // the kept id
  void Expire(Clock::time_point now);
  void DropReply(Record& record);

  std::int64_t Bytes() const;

  Retention retention_;
  MemoryCharge charge_;
  std::unordered_map<std::string, Record> records_;  // by request_id
  std::deque<const std::string*> by_age_;            // all ids in records_, oldest first
  std::deque<const std::string*> replies_by_age_;    // ids of ingests, oldest first
  std::int64_t reply_bytes_ = 0;
};

}  // namespace cwm::server
