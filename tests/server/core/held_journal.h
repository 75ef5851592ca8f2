// A journal that answers when the test says so.
#pragma once

#include <deque>
#include <mutex>
#include <span>
#include <string>
#include <utility>

#include "server/core/journal.h"

namespace cwm::server {

class HeldJournal final : public Journal {
 public:
  void Append(const JournalEntry& entry, Done done) override {
    const std::lock_guard lock(mutex_);
    waiting_.push_back({entry, std::move(done)});
  }
  absl::Status KeepGeometry(std::span<const PreparedModelPtr>, Durability) override {
    return absl::OkStatus();
  }
  absl::StatusOr<std::string> KeepRobotFiles(const RobotFiles&) override { return ""; }

  std::size_t waiting() const {
    const std::lock_guard lock(mutex_);
    return waiting_.size();
  }
  JournalEntry entry(std::size_t i) const {
    const std::lock_guard lock(mutex_);
    return waiting_[i].entry;
  }

  // Answers the oldest entry.
  void Answer(const absl::Status& status = absl::OkStatus()) {
    Waiting first;
    {
      const std::lock_guard lock(mutex_);
      first = std::move(waiting_.front());
      waiting_.pop_front();
    }
    first.done(status);
  }
  void AnswerAll(const absl::Status& status = absl::OkStatus()) {
    while (waiting() > 0) Answer(status);
  }

 private:
  struct Waiting {
    JournalEntry entry = {};
    Done done = {};
  };
  mutable std::mutex mutex_;
  std::deque<Waiting> waiting_;
};

}  // namespace cwm::server
