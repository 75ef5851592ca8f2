// A client that queries a world again and again, each time at a revision that it has not seen: the
// time at which a query sees a change.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "clients/cpp/connection.h"
#include "tests/benchmarks/live/live_client.h"

namespace cwm::benchmarks {

class RevisionProbe {
 public:
  // Begins after the revision that the world has; the world exists.
  RevisionProbe(const std::string& address, std::string world);
  ~RevisionProbe();
  RevisionProbe(const RevisionProbe&) = delete;
  RevisionProbe& operator=(const RevisionProbe&) = delete;

  // When a query was first answered at this revision or a later one; empty if none was.
  std::optional<SteadyClock::time_point> SeenAt(std::int64_t revision) const;
  // Number of answers.
  std::size_t seen_count() const;

 private:
  void Run();

  const std::string world_;
  const client::Connection connection_;
  std::atomic<bool> stops_ = false;
  mutable std::mutex mutex_;
  struct Seen {
    std::int64_t revision = 0;
    SteadyClock::time_point at = {};
  };
  std::vector<Seen> seen_;  // ascending
  std::thread thread_;
};

// Milliseconds from the last byte of each frame, from the frame `first` on, that moved something to
// the answer of a query that sees its revision.
std::vector<double> ChangeTimes_ms(const std::vector<FrameAnswer>& answers, std::size_t first,
                                   const RevisionProbe& probe);

}  // namespace cwm::benchmarks
