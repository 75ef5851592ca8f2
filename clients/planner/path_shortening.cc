#include "clients/planner/path_shortening.h"

#include <ompl/util/RandomNumbers.h>

#include <algorithm>
#include <utility>

namespace cwm::planner {
namespace {

// measured: shortcuts graze obstacles, so the final path is checked again with each fine step split
// into two. Of 700 problems of MotionBenchMaker 14 paths have contact between states with 1 part, 7
// with 2, 6 with 4.
constexpr std::size_t kFinalParts = 2;

// chosen: a smaller saving is not worth two queries.
constexpr double kMinSaving = 0.01;

// A point on a path: after `motion` whole motions, at a fraction of the next.
struct PathPoint {
  std::size_t motion = 0;
  double fraction = 0;
  double along = 0;  // length of the path up to it
  Row row;
};

struct Shortcut {
  PathPoint from, to;
  double saving = 0;
};

class PathShortener {
 public:
  PathShortener(const JointSpace& space, StateChecker& checker, std::vector<Row> path,
                const ShorteningOptions& options)
      : space_(space),
        options_(options),
        batch_(space, checker),
        random_(options.seed),
        path_(std::move(path)) {}

  absl::StatusOr<std::vector<Row>> Run() {
    int idle = 0;
    for (int round = 0; round < options_.rounds && idle < 2 && path_.size() > 2; ++round) {
      std::vector<Row> before = path_;
      const auto taken = Round(round == 0);
      if (!taken.ok()) return taken.status();
      idle = *taken > 0 ? 0 : idle + 1;
      if (*taken > 0) earlier_.push_back(std::move(before));
    }
    return LatestFreePath();
  }

 private:
  // Returns the latest path that is free at the fine step. A motion of which a shortcut left only a
  // part was not checked at that part's states, so the whole path is checked again; if a state is
  // not free, the path before the last round is tried.
  absl::StatusOr<std::vector<Row>> LatestFreePath() {
    for (; !earlier_.empty(); earlier_.pop_back()) {
      for (std::size_t k = 1; k < path_.size(); ++k)
        batch_.Add(path_[k - 1], path_[k], kFineStep, kFinalParts);
      if (const absl::Status status = batch_.CheckAll(); !status.ok()) return status;
      bool is_free = true;
      for (std::size_t k = 0; k + 1 < path_.size(); ++k) is_free = is_free && batch_.IsFree(k);
      if (is_free) break;
      path_ = earlier_.back();
    }
    return std::move(path_);  // without an earlier path, the given one
  }

  void Measure() {
    along_.assign(1, 0);
    for (std::size_t k = 1; k < path_.size(); ++k) {
      along_.push_back(along_.back() + space_.Distance(path_[k - 1], path_[k]));
    }
  }

  PathPoint AtVertex(std::size_t k) const {
    return {.motion = k, .fraction = 0, .along = along_[k], .row = path_[k]};
  }

  PathPoint AtLength(double along) const {
    const auto after = std::upper_bound(along_.begin(), along_.end() - 1, along);
    const auto motion = static_cast<std::size_t>(after - along_.begin()) - 1;
    if (motion + 1 == path_.size()) return AtVertex(motion);
    const double length = along_[motion + 1] - along_[motion];
    PathPoint point{.motion = motion, .fraction = 0, .along = along, .row = Row(space_.width())};
    point.fraction = length > 0 ? std::min(1.0, (along - along_[motion]) / length) : 0;
    space_.Interpolate(path_[motion], path_[motion + 1], point.fraction, point.row);
    return point;
  }

  void Propose(PathPoint from, PathPoint to, std::vector<Shortcut>& shortcuts) const {
    if (from.motion == to.motion) return;
    const double saving = to.along - from.along - space_.Distance(from.row, to.row);
    if (saving > kMinSaving) shortcuts.push_back({std::move(from), std::move(to), saving});
  }

  // Proposes shortcuts between vertices first, since these save most.
  std::vector<Shortcut> Proposals(bool of_vertices) {
    std::vector<Shortcut> shortcuts;
    if (of_vertices) {
      for (std::size_t gap = path_.size() - 1; gap >= 2; --gap) {
        for (std::size_t k = 0; k + gap < path_.size(); ++k) {
          if (shortcuts.size() < 2 * static_cast<std::size_t>(options_.shortcuts)) {
            Propose(AtVertex(k), AtVertex(k + gap), shortcuts);
          }
        }
      }
      return shortcuts;
    }
    for (int k = 0; k < options_.shortcuts; ++k) {
      const double a = random_.uniformReal(0, along_.back());
      const double b = random_.uniformReal(0, along_.back());
      Propose(AtLength(std::min(a, b)), AtLength(std::max(a, b)), shortcuts);
    }
    return shortcuts;
  }

  // Returns the number of shortcuts taken.
  absl::StatusOr<int> Round(bool of_vertices) {
    Measure();
    std::vector<Shortcut> shortcuts = Proposals(of_vertices);
    for (const Shortcut& shortcut : shortcuts)
      batch_.Add(shortcut.from.row, shortcut.to.row, kCoarseStep);
    if (const absl::Status status = batch_.CheckAll(); !status.ok()) return status;
    std::vector<Shortcut> chosen;
    std::vector<std::size_t> order;
    for (std::size_t k = 0; k < shortcuts.size(); ++k) {
      if (batch_.IsFree(k)) order.push_back(k);
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return shortcuts[a].saving > shortcuts[b].saving;
    });
    for (const std::size_t k : order) {
      const bool is_apart = std::all_of(chosen.begin(), chosen.end(), [&](const Shortcut& other) {
        return shortcuts[k].to.along <= other.from.along ||
               other.to.along <= shortcuts[k].from.along;
      });
      if (is_apart) chosen.push_back(shortcuts[k]);
    }
    for (const Shortcut& shortcut : chosen)
      batch_.Add(shortcut.from.row, shortcut.to.row, kFineStep);
    if (const absl::Status status = batch_.CheckAll(); !status.ok()) return status;
    std::vector<Shortcut> taken;
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      if (batch_.IsFree(k)) taken.push_back(chosen[k]);
    }
    Take(std::move(taken));
    return static_cast<int>(taken_count_);
  }

  void Take(std::vector<Shortcut> shortcuts) {
    taken_count_ = shortcuts.size();
    std::sort(shortcuts.begin(), shortcuts.end(),
              [](const Shortcut& a, const Shortcut& b) { return a.from.along < b.from.along; });
    std::vector<Row> path;
    std::size_t next = 0;  // index into the old vertices
    for (Shortcut& shortcut : shortcuts) {
      for (; next <= shortcut.from.motion; ++next) path.push_back(path_[next]);
      if (shortcut.from.fraction > 0) path.push_back(std::move(shortcut.from.row));
      if (shortcut.to.fraction > 0) path.push_back(std::move(shortcut.to.row));
      next = shortcut.to.fraction > 0 ? shortcut.to.motion + 1 : shortcut.to.motion;
    }
    for (; next < path_.size(); ++next) path.push_back(path_[next]);
    path_ = std::move(path);
  }

  const JointSpace& space_;
  const ShorteningOptions options_;
  EdgeBatch batch_;
  ompl::RNG random_;
  std::vector<Row> path_;
  std::vector<std::vector<Row>> earlier_;  // the path before each round that changed it
  std::vector<double> along_;              // path length up to each vertex
  std::size_t taken_count_ = 0;
};

}  // namespace

double LengthOf(const JointSpace& space, const std::vector<Row>& path) {
  double length = 0;
  for (std::size_t k = 1; k < path.size(); ++k) length += space.Distance(path[k - 1], path[k]);
  return length;
}

absl::StatusOr<std::vector<Row>> Shorten(const JointSpace& space, StateChecker& checker,
                                         std::vector<Row> path, const ShorteningOptions& options) {
  return PathShortener(space, checker, std::move(path), options).Run();
}

}  // namespace cwm::planner
