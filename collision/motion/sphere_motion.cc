#include "collision/motion/sphere_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/motion/body_motion.h"
#include "collision/robot/kinematics.h"

namespace cwm::collision {
namespace {

// chosen: narrower intervals are left to the search in double precision, which needs a few
// measurements of one pair for what is so near to contact.
constexpr double kMinInterval = 0.5 * kMaxBracketWidth;
// chosen: the same for spheres that prove gaps only, which leave most of what they do not prove in
// the first intervals.
constexpr double kMinGapInterval = 1.0 / 64;
// chosen: as in the search pair by pair, intervals are accepted if the proven clearance is at least
// this share of the gap, unless they are narrow.
constexpr float kMinClearanceShare = 0.25F;
constexpr double kMinClearanceInterval = 1.0 / 256;
// chosen: an edge along which spheres slide past each other takes tens of these.
constexpr int kMaxBatches = 64;

}  // namespace

SphereMotion::SphereMotion(const JointRows& rows, SphereQuery query)
    : rows_(&rows),
      query_(std::make_shared<const SphereQuery>(std::move(query))),
      // Spheres around links tell less clearance than the links have.
      edge_maker_(*query_->program, query_->proves_contact ? 0 : kLaneClearance_m),
      min_width_(query_->proves_contact ? kMinInterval : kMinGapInterval) {
  const std::vector<int>& variables = rows.group().variables;
  for (const int variable : variables) {
    is_cyclic_.push_back(IsCyclic(rows.model(), static_cast<std::size_t>(variable)));
  }
  state_ = rows.states().base;
  from_.resize(variables.size());
  step_.resize(variables.size());
}

std::optional<SphereMotion> SphereMotion::Make(const WorldSnapshot& world, const QueryBody& body,
                                               const JointRows& rows, const QueryOptions& options) {
  if (options.unseen == UnseenSpace::kReport) return std::nullopt;
  // An edge takes so long pair by pair that compiling its spheres always pays off.
  constexpr std::size_t kManyRows = std::numeric_limits<std::size_t>::max();
  std::optional<SphereQuery> query = CompileQuery(world, body, rows, kManyRows, options);
  if (!query) return std::nullopt;
  return SphereMotion(rows, *std::move(query));
}

SphereMotionAnswer SphereMotion::Check(std::size_t row) {
  const std::size_t width = step_.size();
  const double* const rows = rows_->states().rows.data() + row * width;
  for (std::size_t k = 0; k < width; ++k) {
    from_[k] = rows[k];
    step_[k] = StepOf(is_cyclic_[k], rows[k], rows[k + width]);
  }
  edge_ = edge_maker_.Make(from_, step_);
  if (edge_ == nullptr) return {};
  // Gaps do not tell the accuracy of some pairs, which are left to the search.
  const UnresolvedTags& apart = query_->tags_for_accuracy;
  SphereMotionAnswer answer{.open = OpenTimes::None()};
  answer.open.Add(apart, {});
  todo_.assign(1, {.open = {~apart.worlds, ~apart.pairs}});
  for (int batch = 0; !todo_.empty(); ++batch) {
    double first = todo_.front().span.from;
    if (!answer.open.empty()) first = std::min(first, answer.open.Whole().from);
    if (answer.hi - first <= kMaxBracketWidth) {
      answer.lo = first;
      answer.open = OpenTimes::None();
      return answer;
    }
    if (batch == kMaxBatches) return {};
    Evaluate(Divide(answer.has_contact()), answer.has_contact());
    Sort(answer);
  }
  if (answer.has_contact()) answer.open.ClipAt(answer.hi);
  return answer;
}

void SphereMotion::Place(double fraction, std::span<Pose> X_WL) {
  const std::vector<int>& variables = rows_->group().variables;
  for (std::size_t k = 0; k < variables.size(); ++k) {
    state_[static_cast<std::size_t>(variables[k])] = from_[k] + fraction * step_[k];
  }
  LinkPoses(rows_->model(), rows_->states().X_WB, state_, X_WL);
}

// Moves the first tasks to the batch, each divided into equal parts, and returns what is open in
// them. If only the start is left before a known contact, its first moment is a part of its own.
UnresolvedTags SphereMotion::Divide(bool is_contact_known) {
  constexpr std::size_t kMaxTaken = kIntervals / 2;
  const std::size_t taken = std::min(todo_.size(), kMaxTaken);
  const bool asks_start = taken == 1 && todo_.front().span.from == 0 && is_contact_known;
  const std::size_t parts = (kIntervals - (asks_start ? 1 : 0)) / taken;
  UnresolvedTags needed;
  batch_.clear();
  if (asks_start) batch_.push_back({0, 0});
  for (std::size_t k = 0; k < taken; ++k) {
    const TimeSpan& whole = todo_[k].span;
    needed.worlds |= todo_[k].open.worlds;
    needed.pairs |= todo_[k].open.pairs;
    const auto at = [&](std::size_t part) {
      const double share = static_cast<double>(part) / static_cast<double>(parts);
      return part == parts ? whole.to : whole.from + whole.width() * share;
    };
    for (std::size_t part = 0; part < parts; ++part) batch_.push_back({at(part), at(part + 1)});
  }
  todo_.erase(todo_.begin(), todo_.begin() + static_cast<std::ptrdiff_t>(taken));
  return needed;
}

void SphereMotion::Evaluate(const UnresolvedTags& needed, bool is_contact_known) {
  constexpr double kRoundedUp = 1.000001;
  Intervals intervals{.count = batch_.size(), .needed = needed};
  for (std::size_t i = 0; i < batch_.size(); ++i) {
    intervals.middle[i] = batch_[i].middle();
    intervals.half_width[i] = static_cast<float>(kRoundedUp * 0.5 * batch_[i].width());
    // No clearance is told with a contact.
    const bool tells_clearance = !is_contact_known && batch_[i].width() > kMinClearanceInterval;
    intervals.least_share[i] = tells_clearance ? kMinClearanceShare : 0;
  }
  CheckIntervals(query_->program->lanes, query_->scene, *edge_, intervals, memory_, results_);
}

// Keeps the intervals of the batch that are not proven, up to the first contact: those that
// narrower ones can prove are left to do, the others stay open.
void SphereMotion::Sort(SphereMotionAnswer& answer) {
  std::vector<Task> left;
  for (std::size_t i = 0; i < batch_.size(); ++i) {
    const TimeSpan& span = batch_[i];
    const IntervalResult& result = results_[i];
    answer.clearance_m = std::min(answer.clearance_m, double{result.clearance_m});
    if (result.is_contact) {
      answer.tags = result.touching;
      answer.lo = span.from;
      answer.hi = span.middle();
      todo_.clear();
      if (span.width() == 0) return;
      left.push_back({{span.from, answer.hi}, result.open});
      break;
    }
    if (result.is_free() || span.width() == 0) continue;
    if (!result.is_stuck && span.width() >= min_width_) {
      left.push_back({span, result.open});
    } else {
      answer.open.Add(result.open, span);
    }
  }
  todo_.insert(todo_.begin(), left.begin(), left.end());
}

}  // namespace cwm::collision
