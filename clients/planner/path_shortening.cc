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

// A place on a path: after `motion` whole motions, at a share of the next.
struct Place {
  std::size_t motion = 0;
  double share = 0;
  double along = 0;  // length of the path up to it
  Row row;
};

struct Cut {
  Place from, to;
  double saving = 0;
};

class Shortening {
 public:
  Shortening(const JointSpace& space, StateChecker& checker, std::vector<Row> path,
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
    return LatestThatIsFree();
  }

 private:
  // Returns the latest path that is free at the fine step. A motion of which a shortcut left only a
  // part was not checked at that part's states, so the whole path is checked again; if a state is
  // not free, the path before the last round is tried.
  absl::StatusOr<std::vector<Row>> LatestThatIsFree() {
    for (; !earlier_.empty(); earlier_.pop_back()) {
      for (std::size_t k = 1; k < path_.size(); ++k)
        batch_.Add(path_[k - 1], path_[k], kFineStep, kFinalParts);
      if (const absl::Status status = batch_.Ask(); !status.ok()) return status;
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

  Place AtVertex(std::size_t k) const {
    return {.motion = k, .share = 0, .along = along_[k], .row = path_[k]};
  }

  Place AtLength(double along) const {
    const auto after = std::upper_bound(along_.begin(), along_.end() - 1, along);
    const auto motion = static_cast<std::size_t>(after - along_.begin()) - 1;
    if (motion + 1 == path_.size()) return AtVertex(motion);
    const double length = along_[motion + 1] - along_[motion];
    Place place{.motion = motion, .share = 0, .along = along, .row = Row(space_.width())};
    place.share = length > 0 ? std::min(1.0, (along - along_[motion]) / length) : 0;
    space_.Interpolate(path_[motion], path_[motion + 1], place.share, place.row);
    return place;
  }

  void Propose(Place from, Place to, std::vector<Cut>& cuts) const {
    if (from.motion == to.motion) return;
    const double saving = to.along - from.along - space_.Distance(from.row, to.row);
    if (saving > kMinSaving) cuts.push_back({std::move(from), std::move(to), saving});
  }

  // Proposes shortcuts between vertices first, since these save most.
  std::vector<Cut> Proposals(bool of_vertices) {
    std::vector<Cut> cuts;
    if (of_vertices) {
      for (std::size_t gap = path_.size() - 1; gap >= 2; --gap) {
        for (std::size_t k = 0; k + gap < path_.size(); ++k) {
          if (cuts.size() < 2 * static_cast<std::size_t>(options_.cuts)) {
            Propose(AtVertex(k), AtVertex(k + gap), cuts);
          }
        }
      }
      return cuts;
    }
    for (int k = 0; k < options_.cuts; ++k) {
      const double a = random_.uniformReal(0, along_.back());
      const double b = random_.uniformReal(0, along_.back());
      Propose(AtLength(std::min(a, b)), AtLength(std::max(a, b)), cuts);
    }
    return cuts;
  }

  // Returns the number of shortcuts taken.
  absl::StatusOr<int> Round(bool of_vertices) {
    Measure();
    std::vector<Cut> cuts = Proposals(of_vertices);
    for (const Cut& cut : cuts) batch_.Add(cut.from.row, cut.to.row, kCoarseStep);
    if (const absl::Status status = batch_.Ask(); !status.ok()) return status;
    std::vector<Cut> chosen;
    std::vector<std::size_t> order;
    for (std::size_t k = 0; k < cuts.size(); ++k) {
      if (batch_.IsFree(k)) order.push_back(k);
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return cuts[a].saving > cuts[b].saving; });
    for (const std::size_t k : order) {
      const bool is_apart = std::all_of(chosen.begin(), chosen.end(), [&](const Cut& other) {
        return cuts[k].to.along <= other.from.along || other.to.along <= cuts[k].from.along;
      });
      if (is_apart) chosen.push_back(cuts[k]);
    }
    for (const Cut& cut : chosen) batch_.Add(cut.from.row, cut.to.row, kFineStep);
    if (const absl::Status status = batch_.Ask(); !status.ok()) return status;
    std::vector<Cut> taken;
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      if (batch_.IsFree(k)) taken.push_back(chosen[k]);
    }
    Take(std::move(taken));
    return static_cast<int>(taken_);
  }

  void Take(std::vector<Cut> cuts) {
    taken_ = cuts.size();
    std::sort(cuts.begin(), cuts.end(),
              [](const Cut& a, const Cut& b) { return a.from.along < b.from.along; });
    std::vector<Row> path;
    std::size_t next = 0;  // index into the old vertices
    for (Cut& cut : cuts) {
      for (; next <= cut.from.motion; ++next) path.push_back(path_[next]);
      if (cut.from.share > 0) path.push_back(std::move(cut.from.row));
      if (cut.to.share > 0) path.push_back(std::move(cut.to.row));
      next = cut.to.share > 0 ? cut.to.motion + 1 : cut.to.motion;
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
  std::size_t taken_ = 0;
};

}  // namespace

double LengthOf(const JointSpace& space, const std::vector<Row>& path) {
  double length = 0;
  for (std::size_t k = 1; k < path.size(); ++k) length += space.Distance(path[k - 1], path[k]);
  return length;
}

absl::StatusOr<std::vector<Row>> Shorten(const JointSpace& space, StateChecker& checker,
                                         std::vector<Row> path, const ShorteningOptions& options) {
  return Shortening(space, checker, std::move(path), options).Run();
}

}  // namespace cwm::planner
