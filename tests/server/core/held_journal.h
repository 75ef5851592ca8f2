// A journal that answers when the test says so.
#pragma once

#include <deque>
#include <span>
#include <string>
#include <utility>

#include "server/core/journal.h"

namespace cwm::server {

class HeldJournal final : public Journal {
 public:
  void Append(const JournalEntry& entry, Done done) override {
    waiting_.push_back({entry, std::move(done)});
  }
  absl::Status KeepGeometry(std::span<const PreparedModelPtr>, Durability) override {
    return absl::OkStatus();
  }
  absl::StatusOr<std::string> KeepRobotFiles(const RobotFiles&) override { return ""; }

  std::size_t waiting() const { return waiting_.size(); }
  const JournalEntry& entry(std::size_t i) const { return waiting_[i].entry; }

  // Answers the oldest entry.
  void Answer(const absl::Status& status = absl::OkStatus()) {
    Waiting first = std::move(waiting_.front());
    waiting_.pop_front();
    first.done(status);
  }
  void AnswerAll(const absl::Status& status = absl::OkStatus()) {
    while (!waiting_.empty()) Answer(status);
  }

 private:
  struct Waiting {
    JournalEntry entry;
    Done done;
  };
  std::deque<Waiting> waiting_;
};

}  // namespace cwm::server
