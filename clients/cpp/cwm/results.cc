#include "cwm/results.h"

#include <algorithm>
#include <limits>

#include "absl/strings/str_cat.h"
#include "cwm/error.h"

namespace cwm::CWM_API {
namespace {

std::size_t At(Eigen::Index index) { return static_cast<std::size_t>(index); }

std::string TextAt(const std::vector<std::string>& list, int index) {
  return index >= 0 && At(index) < list.size() ? list[At(index)] : "";
}

std::string ObjectAt(const std::vector<AnsweredObject>& objects, int index) {
  return index >= 0 && At(index) < objects.size() ? objects[At(index)].name : "";
}

NamedPairOfParts PairAt(const ResultHead& head, const PairColumns& pairs, Eigen::Index i) {
  const int object = pairs.object_index[i], part = pairs.object_part[i];
  NamedPairOfParts pair{.body_link = TextAt(pairs.body_links, pairs.body_part[i]),
                        .body_object = TextAt(pairs.body_objects, pairs.body_part[i])};
  if (object == kItself) {
    pair.object = pairs.robot;
    pair.object_link = TextAt(pairs.body_links, part);
  } else if (object >= 0) {
    pair.object = ObjectAt(head.objects, object);
    pair.object_link = TextAt(head.objects[At(object)].part_links, part);
  }
  return pair;
}

}  // namespace

const char* NameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kFree:
      return "FREE";
    case Verdict::kCollision:
      return "COLLISION";
    case Verdict::kOutOfLimits:
      return "OUT_OF_LIMITS";
    case Verdict::kUndecided:
      return "UNDECIDED";
    case Verdict::kNotComputed:
      return "NOT_COMPUTED";
  }
  return "?";
}

const char* NameOf(MotionVerdict verdict) {
  switch (verdict) {
    case MotionVerdict::kFree:
      return "FREE";
    case MotionVerdict::kContact:
      return "CONTACT";
    case MotionVerdict::kGrazing:
      return "GRAZING";
    case MotionVerdict::kUndecided:
      return "UNDECIDED";
    case MotionVerdict::kNotComputed:
      return "NOT_COMPUTED";
    case MotionVerdict::kOutOfLimits:
      return "OUT_OF_LIMITS";
  }
  return "?";
}

const char* NameOf(Trust trust) {
  switch (trust) {
    case Trust::kNone:
      return "NONE";
    case Trust::kExact:
      return "EXACT";
    case Trust::kBounded:
      return "BOUNDED";
    case Trust::kSurfaceOnly:
      return "SURFACE_ONLY";
    case Trust::kDegraded:
      return "DEGRADED";
  }
  return "?";
}

const char* NameOf(SampleState state) {
  switch (state) {
    case SampleState::kSmooth:
      return "SMOOTH";
    case SampleState::kKink:
      return "KINK";
    case SampleState::kBeyond:
      return "BEYOND";
  }
  return "?";
}

const char* NameOf(PoseStatus status) {
  switch (status) {
    case PoseStatus::kSolved:
      return "SOLVED";
    case PoseStatus::kUnreachable:
      return "UNREACHABLE";
    case PoseStatus::kOutOfLimits:
      return "OUT_OF_LIMITS";
    case PoseStatus::kInCollision:
      return "IN_COLLISION";
    case PoseStatus::kNotComputed:
      return "NOT_COMPUTED";
  }
  return "?";
}

bool CheckResult::free(Eigen::Index row) const { return verdict[At(row)] == Verdict::kFree; }

bool CheckResult::all_free() const {
  return complete() && std::all_of(verdict.begin(), verdict.end(),
                                   [](Verdict one) { return one == Verdict::kFree; });
}

NamedPairOfParts CheckResult::pair(Eigen::Index row) const { return PairAt(*this, *this, row); }

NamedPairOfParts PairResult::pair(Eigen::Index answer) const {
  return PairAt(*this, *this, answer);
}

Eigen::VectorXd PairResult::nearest_m() const {
  Eigen::VectorXd nearest(static_cast<Eigen::Index>(row_begin.size()) - 1);
  for (Eigen::Index i = 0; i < nearest.size(); ++i) {
    const Eigen::Index begin = row_begin[At(i)], count = row_begin[At(i) + 1] - begin;
    nearest[i] = count == 0 ? std::numeric_limits<double>::quiet_NaN()
                            : distance_m.segment(begin, count).minCoeff();
  }
  return nearest;
}

bool MotionResult::free(Eigen::Index motion) const {
  return verdict[At(motion)] == MotionVerdict::kFree;
}

bool MotionResult::all_free() const {
  return complete() && std::all_of(verdict.begin(), verdict.end(),
                                   [](MotionVerdict one) { return one == MotionVerdict::kFree; });
}

NamedPairOfParts MotionResult::pair(Eigen::Index motion) const {
  return PairAt(*this, *this, motion);
}

std::string RayResult::object(Eigen::Index ray) const {
  return hit[At(ray)] ? ObjectAt(objects, object_index[ray]) : "";
}

std::string SampleResult::object(Eigen::Index point) const {
  return state[At(point)] == SampleState::kBeyond ? "" : ObjectAt(objects, object_index[point]);
}

bool PoseResult::solved(Eigen::Index pose) const { return status[At(pose)] == PoseStatus::kSolved; }

Eigen::MatrixXd PoseResult::solutions(Eigen::Index pose) const {
  if (!solved(pose)) return states.leftCols(0);
  return states.middleCols(row_begin[At(pose)], row_begin[At(pose) + 1] - row_begin[At(pose)]);
}

const Eigen::Isometry3d& LinkPoses::pose(Eigen::Index row, const std::string& link) const {
  const auto found = std::find(links.begin(), links.end(), link);
  if (found == links.end()) {
    throw Error(ErrorCode::kNotFound,
                absl::StrCat("link \"", link, "\" is none of those that were asked for"));
  }
  return X_WL[At(row) * links.size() + static_cast<std::size_t>(found - links.begin())];
}

}  // namespace cwm::CWM_API
