#include "collision/motion/sphere_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/motion/body_motion.h"
#include "collision/motion/check_motions.h"

namespace cwm::collision {
namespace {

// chosen: narrower intervals are left to the search in double precision, which needs a few
// measurements of one pair for what is so near to contact.
constexpr double kMinInterval = 1.0 / 512;
// chosen: the same for spheres that prove gaps only, which leave most of what they do not prove in
// the first intervals.
constexpr double kMinGapInterval = 1.0 / 64;
// chosen: as in the search pair by pair, an interval is accepted if its proven clearance is at least
// this share of the gap at its middle, unless a contact is known, with which no clearance is told.
constexpr double kMinClearanceShare = 0.25;
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
  from_.resize(variables.size());
  step_.resize(variables.size());
  states_.resize(kIntervals * variables.size());
  values_.resize(query_->program->inputs.size() * kMaxLanes);
}

std::optional<SphereMotion> SphereMotion::Make(const WorldSnapshot& world, const QueryBody& body,
                                               const JointRows& rows, const QueryOptions& options) {
  if (options.unseen == UnseenSpace::kReport) return std::nullopt;
  // An edge takes so long pair by pair that compiling its spheres always pays off.
  constexpr std::size_t kManyRows = std::numeric_limits<std::size_t>::max();
  std::optional<SphereQuery> query = CompileQuery(world, body, rows, kManyRows, options);
  if (!query || query->tags_for_accuracy.worlds != 0 || query->tags_for_accuracy.pairs != 0) {
    return std::nullopt;
  }
  return SphereMotion(rows, *std::move(query));
}

SphereMotionAnswer SphereMotion::Check(std::size_t row) {
  const std::size_t width = step_.size();
  const double* const rows = rows_->states().rows.data() + row * width;
  for (std::size_t k = 0; k < width; ++k) {
    from_[k] = rows[k];
    step_[k] = StepOf(is_cyclic_[k], rows[k], rows[k + width]);
  }
  edge_ = &edge_maker_.Make(from_, step_);
  SphereMotionAnswer answer{.open = OpenTimes::None()};
  todo_.assign(1, {});
  for (int batch = 0; !todo_.empty(); ++batch) {
    if (answer.hi - todo_.front().from <= kMaxBracketWidth) {
      answer.lo = todo_.front().from;
      break;
    }
    Divide(answer.has_contact());
    if (batch == kMaxBatches || !Evaluate()) return {};
    Sort(answer);
  }
  if (answer.has_contact()) answer.open.ClipAt(answer.hi);
  return answer;
}

// Moves the first intervals that are not proven to the batch, each divided into equal parts. If only the start is
// open before a known contact, its first moment is a part of its own.
void SphereMotion::Divide(bool is_contact_known) {
  constexpr std::size_t kMaxTaken = kIntervals / 2;
  const std::size_t taken = std::min(todo_.size(), kMaxTaken);
  const bool asks_start = taken == 1 && todo_.front().from == 0 && is_contact_known;
  const std::size_t parts = (kIntervals - (asks_start ? 1 : 0)) / taken;
  batch_.clear();
  if (asks_start) batch_.push_back({0, 0});
  for (std::size_t k = 0; k < taken; ++k) {
    const TimeSpan& whole = todo_[k];
    const auto at = [&](std::size_t part) {
      return part == parts ? whole.to
                           : whole.from + whole.width() * static_cast<double>(part) /
                                              static_cast<double>(parts);
    };
    for (std::size_t part = 0; part < parts; ++part) batch_.push_back({at(part), at(part + 1)});
  }
  todo_.erase(todo_.begin(), todo_.begin() + static_cast<std::ptrdiff_t>(taken));
}

// False if some state of the batch is out of range.
bool SphereMotion::Evaluate() {
  const std::size_t width = step_.size();
  std::array<float, kIntervals> half_widths{};
  for (std::size_t i = 0; i < batch_.size(); ++i) {
    const double middle = batch_[i].middle();
    for (std::size_t k = 0; k < width; ++k) {
      states_[i * width + k] = from_[k] + middle * step_[k];
    }
    constexpr double kRoundedUp = 1.000001;
    half_widths[i] = static_cast<float>(kRoundedUp * 0.5 * batch_[i].width());
  }
  const std::vector<LaneInput>& inputs = query_->program->inputs;
  LoadStates(inputs, states_.data(), width, batch_.size(), kMaxLanes, values_.data(),
             marks_.data());
  for (std::size_t i = 0; i < batch_.size(); ++i) {
    if (marks_[i] != StateMark::kReady) return false;
  }
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    std::fill(values_.begin() + static_cast<std::ptrdiff_t>(k * kMaxLanes + batch_.size()),
              values_.begin() + static_cast<std::ptrdiff_t>((k + 1) * kMaxLanes), 0.0F);
  }
  CheckIntervals(query_->program->lanes, query_->scene, *edge_, values_.data(), kMaxLanes,
                 std::span(half_widths).first(batch_.size()), memory_, results_);
  return true;
}

// Keeps the intervals of the batch that are not proven, up to the first contact: those that narrower
// ones can prove are left to do, the others stay open.
void SphereMotion::Sort(SphereMotionAnswer& answer) {
  std::vector<TimeSpan> left;
  for (std::size_t i = 0; i < batch_.size(); ++i) {
    const TimeSpan& span = batch_[i];
    const IntervalResult& result = results_[i];
    if (result.verdict == IntervalVerdict::kContact) {
      answer.tags = result.tags;
      answer.lo = span.from;
      answer.hi = span.middle();
      todo_.clear();
      if (span.width() == 0) return;
      left.push_back({span.from, answer.hi});
      break;
    }
    const bool is_free = result.verdict == IntervalVerdict::kFree;
    const bool is_good =
        answer.has_contact() || result.clearance_m >= kMinClearanceShare * result.gap_m;
    if (is_free && (is_good || span.width() < min_width_)) {
      answer.clearance_m = std::min(answer.clearance_m, double{result.clearance_m});
    } else if (is_free || (!result.is_stuck && span.width() >= min_width_)) {
      left.push_back(span);
    } else if (span.width() > 0) {
      answer.open.Add(result.tags, span);
    }
  }
  todo_.insert(todo_.begin(), left.begin(), left.end());
}

}  // namespace cwm::collision
