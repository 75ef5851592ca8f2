// The log of one world, as the checker rebuilds it from what its clients sent and saw.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/fault/checker.h"
#include "tests/fault/history.h"

namespace cwm::fault {

// A write with all its attempts under one request id.
struct LogicalWrite {
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

  std::vector<const Operation*> attempts = {};  // in the order of time, never empty
  std::string world_uid = {};
  std::int64_t revision = 0;  // of the first acknowledgement
  std::int64_t acknowledged_ns = kNever;
  bool had_unknown = false;
  bool is_unresolved = false;  // it may be in the world or not

  const Operation& first() const { return *attempts.front(); }
  bool is_acknowledged() const { return acknowledged_ns != kNever; }
};

// A power cut as one world lived through it.
struct CutPoint {
  std::int64_t invoke_ns = 0;
  std::int64_t return_ns = 0;
  // The revision after the restart; empty if nobody looked.
  std::optional<std::int64_t> shown = {};
  // The newest revision that the cut left: the one shown, or the one that it skips from.
  std::optional<std::int64_t> kept = {};
};

struct LoggedRevision {
  const LogicalWrite* author = nullptr;
  // The server skipped numbers after a power cut. The world is as before, and watches are told by a
  // bookmark.
  bool is_skip = false;
  std::optional<ModelHash> hash = {};        // empty: what the world held is not known
  std::optional<std::size_t> taken_by = {};  // the cut that took it
  std::int64_t previous = 0;                 // the revision that it was made of
  std::int64_t first_seen_ns = LogicalWrite::kNever;
};

class WorldLog {
 public:
  WorldLog(std::string world, std::string uid) : world_(std::move(world)), uid_(std::move(uid)) {}

  // Before Fold: all that is known of the world.
  void AddWrite(const LogicalWrite* write) { writes_.push_back(write); }
  void AddSeen(std::int64_t revision, std::int64_t time_ns);
  void AddEvents(std::int64_t revision, std::vector<Effect> effects);
  void SetCuts(std::vector<CutPoint> cuts) { cuts_ = std::move(cuts); }
  // Watches cannot resume from revisions that were made before that time.
  void SetForgotten(std::int64_t time_ns) { forgotten_ns_ = time_ns; }

  // Folds the writes. Adds violations of what the revisions hold, and counts.
  void Fold(Report& report);

  const std::string& world() const { return world_; }
  const std::string& uid() const { return uid_; }
  const std::vector<CutPoint>& cuts() const { return cuts_; }
  std::int64_t forgotten_ns() const { return forgotten_ns_; }
  const std::vector<const LogicalWrite*>& writes() const { return writes_; }

  // After Fold.
  const LoggedRevision* Find(std::int64_t revision) const;
  std::int64_t newest() const { return revisions_.empty() ? 0 : revisions_.rbegin()->first; }
  // The number of cuts that were over at that time.
  std::size_t EpochAt(std::int64_t time_ns) const;
  // The first revision after that one with events, for who watches in that epoch; empty if there is
  // none.
  std::optional<std::int64_t> Next(std::int64_t revision, std::size_t epoch) const;

 private:
  struct Step {
    std::int64_t revision;
    const ModelWorld* before;  // nullptr: not known
  };
  void FindSkips();
  void FillHoles(Report& report);
  void MarkTaken(Report& report);
  std::optional<ModelWorld> After(const Step& step, LoggedRevision& logged, Report& report);
  std::optional<ModelWorld> AfterEvents(const Step& step, LoggedRevision& logged, Report& report);
  std::optional<ModelWorld> AfterWrites(const Step& step, LoggedRevision& logged, Report& report);
  void Complain(Report& report, const std::string& rule, const std::string& text) const;

  std::string world_;
  std::string uid_;
  std::vector<const LogicalWrite*> writes_;
  std::multimap<std::int64_t, const LogicalWrite*> claims_;  // acknowledged, by revision
  std::vector<const LogicalWrite*> unresolved_;
  std::map<std::int64_t, std::vector<Effect>> events_;
  std::map<std::int64_t, LoggedRevision> revisions_;
  std::vector<CutPoint> cuts_;
  std::int64_t forgotten_ns_ = 0;
};

// The write on one line, for reports.
std::string TextOf(const LogicalWrite& write);

}  // namespace cwm::fault
