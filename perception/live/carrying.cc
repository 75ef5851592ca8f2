#include "perception/live/carrying.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace cwm::perception {
namespace {

using std::chrono::milliseconds;

// chosen: a body is told from its old place within this time, unless it moves so slowly that it is
// followed by itself.
constexpr milliseconds kWindow{500};
// chosen: a body and a link that have moved as one for so long, and by so many times the noise.
constexpr milliseconds kAsOne{200};
constexpr double kMovedGates = 4;
// chosen: what a link moves in that time, at 1 m/s.
constexpr double kFarthest_m = 0.5;
// chosen: hypotheses whose poses differ by less say the same.
constexpr double kSamePose_m = 0.001;
// chosen: odds that differ by less are equal.
constexpr double kEqualOdds = 2;
// chosen: one frame alone never decides that a body is not there.
constexpr int kMinLostFrames = 2;
// chosen: the place in the gripper is a mean over so many frames, so that slips are followed.
constexpr int kMaxFits = 8;

double ReachOf_m(const FrameEvidence& frame, const Pose& X_WB) {
  return RobotMargins().calibration_m + FitGate_m(frame, X_WB);
}

// An upper bound of LargestShift_m that costs no samples.
double ShiftBound_m(const BodySurface& body, const Pose& a, const Pose& b) {
  const Vector3 center_B = body.bounds_O().center();
  const Matrix3 turn = a.linear().transpose() * b.linear();
  return (a * center_B - b * center_B).norm() +
         Eigen::AngleAxisd(turn).angle() * 0.5 * body.bounds_O().diagonal().norm();
}

const RobotLinks* FindRobot(std::span<const RobotLinks> robots, const std::string& name) {
  const auto found = std::ranges::find(robots, name, &RobotLinks::robot);
  return found == robots.end() ? nullptr : &*found;
}

const Pose* FindLink(std::span<const RobotLinks> robots, const std::string& robot, int index) {
  const RobotLinks* const links = FindRobot(robots, robot);
  if (links == nullptr || static_cast<std::size_t>(index) >= links->links.size()) return nullptr;
  return &links->links[static_cast<std::size_t>(index)].X_WL;
}

// The link that moves both; it may be one of them.
int CommonLink(const LinkTree& tree, int a, int b) {
  // Parents come before children, so the greater index is never above the other.
  while (a != b) {
    int& lower = a > b ? a : b;
    lower = tree.parents[static_cast<std::size_t>(lower)];
  }
  return a;
}

// True if a sample of the body's surface is within reach of the link.
bool IsTouching(const LinkSurface& link, const Pose& X_LB, const BodySurface& body,
                double reach_m) {
  if (link.empty()) return false;
  const auto reach = static_cast<float>(reach_m);
  return std::ranges::any_of(body.samples(), [&](const SurfaceSample& sample) {
    const Eigen::Vector3f p_L = (X_LB * sample.p_O).cast<float>();
    return link.MayBeWithin(p_L, 0, reach) && link.IsWithin(p_L, reach);
  });
}

double LowestHeight_m(const BodySurface& body, const Pose& X_WB) {
  double lowest_m = std::numeric_limits<double>::infinity();
  for (const SurfaceSample& sample : body.samples()) {
    lowest_m = std::min(lowest_m, (X_WB * sample.p_O).z());
  }
  return lowest_m;
}

// The samples that are nearest to a link, as near as noise can tell.
std::vector<Vector3> NearestSamples(const FrameEvidence& frame, const BodySurface& body,
                                    const Pose& X_WB) {
  const double reach_m = ReachOf_m(frame, X_WB);
  std::vector<double> distances_m;
  for (const SurfaceSample& sample : body.samples()) {
    const Vector3 p_W = X_WB * sample.p_O;
    double& distance_m = distances_m.emplace_back(reach_m);
    for (const RobotLinks& robot : frame.robots) {
      for (std::size_t i = 0; i < robot.links.size(); ++i) {
        const LinkSurface& link = robot.surface->links()[i];
        if (link.empty()) continue;
        const Eigen::Vector3f p_L = (robot.links[i].X_WL.inverse() * p_W).cast<float>();
        if (!link.MayBeWithin(p_L, 0, static_cast<float>(distance_m))) continue;
        distance_m = std::min(distance_m, link.Distance_m(p_L, distance_m));
      }
    }
  }
  const double limit_m =
      *std::ranges::min_element(distances_m) + FitGate_m(frame, X_WB) / kGate_sigma;
  std::vector<Vector3> nearest;
  for (std::size_t i = 0; i < distances_m.size(); ++i) {
    if (distances_m[i] <= limit_m) nearest.push_back(body.samples()[i].p_O);
  }
  return nearest;
}

Pose Between(const Pose& from, const Pose& to, double share) {
  Pose between = Pose::Identity();
  between.translation() = (1 - share) * from.translation() + share * to.translation();
  between.linear() =
      Quaternion(from.linear()).slerp(share, Quaternion(to.linear())).toRotationMatrix();
  return between;
}

NearbySurfaces SurfacesAbout(const FrameEvidence& frame, const BodyEvidence& evidence,
                             const BodySurface& body, std::span<const NeighbourBody> others,
                             const Pose& X_WB) {
  const double radius_m = 0.5 * body.bounds_O().diagonal().norm();
  return {frame, others, evidence.id, X_WB * body.bounds_O().center(), radius_m + kFarthest_m};
}

// True if a link may touch the body.
bool IsLinkNear(const FrameEvidence& frame, const BodySurface& body, const Pose& X_WB) {
  const Vector3 center_W = X_WB * body.bounds_O().center();
  const double reach_m = 0.5 * body.bounds_O().diagonal().norm() + ReachOf_m(frame, X_WB);
  return std::ranges::any_of(frame.robots, [&](const RobotLinks& robot) {
    for (std::size_t i = 0; i < robot.links.size(); ++i) {
      const LinkSurface& link = robot.surface->links()[i];
      if (link.empty()) continue;
      const Vector3 center_L = robot.links[i].X_WL.inverse() * center_W;
      if (link.bounds_L().squaredExteriorDistance(center_L) <= reach_m * reach_m) return true;
    }
    return false;
  });
}

}  // namespace

std::string Carrying::carried_by() const {
  return carrier_ && carrier_->is_held ? carrier_->name : std::string();
}

std::optional<Pose> Carrying::PoseAt(std::span<const RobotLinks> robots) const {
  if (!carrier_) return std::nullopt;
  const Pose* const X_WL = FindLink(robots, carrier_->robot, carrier_->index);
  if (X_WL == nullptr) return std::nullopt;
  return Pose(*X_WL * carrier_->X_LB);
}

void Carrying::Remember(const FrameEvidence& frame, const BodySurface& body, const Pose& X_WB,
                        double log_odds) {
  Moment moment{.stamp = frame.stamp, .X_WB = X_WB, .log_odds = log_odds, .links = {}};
  const double reach_m = ReachOf_m(frame, X_WB);
  for (const RobotLinks& robot : frame.robots) {
    int common = -1;
    std::vector<int> touching;
    for (std::size_t i = 0; i < robot.links.size(); ++i) {
      const Pose X_LB = robot.links[i].X_WL.inverse() * X_WB;
      if (!IsTouching(robot.surface->links()[i], X_LB, body, reach_m)) continue;
      const auto link = static_cast<int>(i);
      common = touching.empty() ? link : CommonLink(*robot.tree, common, link);
      touching.push_back(link);
    }
    if (touching.empty()) continue;
    std::erase(touching, common);
    touching.insert(touching.begin(), common);  // what moves all is asked first
    for (const int link : touching) {
      moment.links.push_back({robot.robot, link, robot.links[static_cast<std::size_t>(link)].X_WL});
    }
  }
  if (!moment.links.empty()) moments_.push_back(std::move(moment));
}

std::vector<Carrying::Candidate> Carrying::Candidates(const FrameEvidence& frame,
                                                      const BodySurface& body,
                                                      const Pose& X_WB) const {
  std::vector<Candidate> candidates;
  for (const Moment& moment : moments_) {
    for (const Link& link : moment.links) {
      const Pose* const X_WL = FindLink(frame.robots, link.robot, link.index);
      if (X_WL == nullptr) continue;
      const Pose X_WB_now = *X_WL * link.X_WL.inverse() * moment.X_WB;
      if (ShiftBound_m(body, X_WB_now, X_WB) < kSamePose_m) continue;
      const bool is_known = std::ranges::any_of(candidates, [&](const Candidate& other) {
        return ShiftBound_m(body, X_WB_now, other.X_WB) < kSamePose_m;
      });
      if (!is_known) candidates.push_back({.since = &moment, .link = &link, .X_WB = X_WB_now});
    }
  }
  return candidates;
}

std::optional<Carrying::Candidate> Carrying::BestCarrier(
    const FrameEvidence& frame, const BodyEvidence& evidence, const BodySurface& body,
    const NearbySurfaces& nearby, const Pose& X_WB, double believed_odds, bool rests) const {
  std::optional<Candidate> best;
  std::optional<Candidate> hidden;  // where the body would not be seen
  for (Candidate& candidate : std::vector(Candidates(frame, body, X_WB))) {
    const PoseEvidence at = EvidenceAt(frame, body, candidate.X_WB, evidence.expected, nearby);
    candidate.log_odds = at.log_odds;
    if (at.IsShown() && at.log_odds > std::max(0.0, believed_odds) + kDecisive) {
      const double least = best ? best->log_odds + kEqualOdds : 0;
      if (at.log_odds > least) best = candidate;
    } else if (at.IsHidden() && at.log_odds > -1 && candidate.since->log_odds > 0) {
      hidden = candidate;  // the newest moment
    }
  }
  if (best) return best;
  if (hidden && rests && believed_odds < -kDecisive) return hidden;
  if (rests) return std::nullopt;
  // Found by itself, it has moved as the link has.
  const double gate_m = FitGate_m(frame, X_WB);
  for (const Moment& moment : moments_) {
    if (frame.stamp - moment.stamp < kAsOne) break;
    if (ShiftBound_m(body, moment.X_WB, X_WB) < kMovedGates * gate_m) continue;
    for (const Link& link : moment.links) {
      const Pose* const X_WL = FindLink(frame.robots, link.robot, link.index);
      if (X_WL == nullptr) continue;
      const Pose X_WB_now = *X_WL * link.X_WL.inverse() * moment.X_WB;
      if (LargestShift_m(body, X_WB_now, X_WB) > gate_m) continue;
      return Candidate{.since = &moment, .link = &link, .X_WB = X_WB, .log_odds = believed_odds};
    }
  }
  return std::nullopt;
}

void Carrying::Begin(const FrameEvidence& frame, const BodySurface& body,
                     const Candidate& candidate, const Pose& X_WB) {
  const RobotLinks& robot = *FindRobot(frame.robots, candidate.link->robot);
  const auto index = static_cast<std::size_t>(candidate.link->index);
  carrier_ = {.robot = robot.robot,
              .index = candidate.link->index,
              .name = robot.robot + "/" + robot.tree->names[index],
              .X_LB = robot.links[index].X_WL.inverse() * X_WB,
              .X_WB_begin = candidate.since->X_WB,
              .touched_B = NearestSamples(frame, body, X_WB)};
  lost_frames_ = 0;
}

void Carrying::NoteHeld(const FrameEvidence& frame, const BodySurface& body, const Pose& X_WB) {
  Carrier& carrier = *carrier_;
  if (carrier.is_held) return;
  const double gate_m = FitGate_m(frame, X_WB);
  const double lifted_m = LowestHeight_m(body, X_WB) - LowestHeight_m(body, carrier.X_WB_begin);
  if (lifted_m > gate_m) {
    carrier.is_held = true;
    return;
  }
  const Vector3 center_B = body.bounds_O().center();
  const Vector3 way_W = X_WB * center_B - carrier.X_WB_begin * center_B;
  if (way_W.norm() < kMovedGates * gate_m) return;
  const Vector3 way_B = X_WB.linear().transpose() * way_W.normalized();
  double half_m = 0;
  for (const SurfaceSample& sample : body.samples()) {
    half_m = std::max(half_m, -(sample.p_O - center_B).dot(way_B));
  }
  const bool is_pushed = std::ranges::any_of(carrier.touched_B, [&](const Vector3& p_B) {
    return (p_B - center_B).dot(way_B) < -0.5 * half_m;
  });
  carrier.is_held = !is_pushed;
}

Carrying::Outcome Carrying::Watch(const FrameEvidence& frame, const BodyEvidence& evidence,
                                  const BodySurface& body, std::span<const NeighbourBody> others,
                                  const Pose& X_WB, bool rests) {
  while (!moments_.empty() && frame.stamp - moments_.front().stamp > kWindow) moments_.pop_front();
  if (moments_.empty() && !IsLinkNear(frame, body, X_WB)) return {};
  const NearbySurfaces nearby = SurfacesAbout(frame, evidence, body, others, X_WB);
  const PoseEvidence believed = EvidenceAt(frame, body, X_WB, evidence.expected, nearby);
  const auto carrier = BestCarrier(frame, evidence, body, nearby, X_WB, believed.log_odds, rests);
  if (!carrier) {
    // A moment at which the body is not where it is believed to be says nothing.
    if (believed.log_odds > -1) Remember(frame, body, X_WB, believed.log_odds);
    return {};
  }
  const Pose X_WB_now = carrier->X_WB;
  Begin(frame, body, *carrier, X_WB_now);
  NoteHeld(frame, body, X_WB_now);
  moments_.clear();
  Remember(frame, body, X_WB_now, carrier->log_odds);
  return {Verdict::kBegins, X_WB_now};
}

Carrying::Outcome Carrying::Follow(const FrameEvidence& frame, const BodyEvidence& evidence,
                                   const BodySurface& body, std::span<const NeighbourBody> others,
                                   const Pose& X_WB, const std::optional<Pose>& fit) {
  while (!moments_.empty() && frame.stamp - moments_.front().stamp > kWindow) moments_.pop_front();
  const NearbySurfaces nearby = SurfacesAbout(frame, evidence, body, others, X_WB);
  const PoseEvidence carried = EvidenceAt(frame, body, X_WB, evidence.expected, nearby);
  // It may rest since one of the last moments.
  std::optional<Pose> rest;
  double rest_odds = std::max(0.0, carried.log_odds) + kDecisive;
  for (const Moment& moment : moments_) {
    if (ShiftBound_m(body, moment.X_WB, X_WB) < kSamePose_m) continue;
    const PoseEvidence at = EvidenceAt(frame, body, moment.X_WB, evidence.expected, nearby);
    if (!at.IsShown() || at.log_odds <= rest_odds) continue;
    rest = moment.X_WB;
    rest_odds = at.log_odds;
  }
  if (rest) {
    Reset();
    return {Verdict::kEnds, *rest};
  }
  Pose X_WB_now = X_WB;
  double odds = carried.log_odds;
  if (fit) {
    const PoseEvidence at = EvidenceAt(frame, body, *fit, evidence.expected, nearby);
    const bool has_slipped = at.log_odds > carried.log_odds + kDecisive;
    if (has_slipped) carrier_->fits = 0;
    if (has_slipped || at.log_odds > carried.log_odds - kEqualOdds) {
      carrier_->fits = std::min(carrier_->fits + 1, kMaxFits);
      X_WB_now = Between(X_WB, *fit, 1.0 / carrier_->fits);
      odds = at.log_odds;
      const Pose& X_WL = *FindLink(frame.robots, carrier_->robot, carrier_->index);
      carrier_->X_LB = X_WL.inverse() * X_WB_now;
    }
  }
  lost_frames_ = odds < -kDecisive ? lost_frames_ + 1 : 0;
  if (lost_frames_ >= kMinLostFrames) {
    Reset();
    return {Verdict::kLost, X_WB_now};
  }
  NoteHeld(frame, body, X_WB_now);
  const std::size_t known = moments_.size();
  Remember(frame, body, X_WB_now, odds);
  if (moments_.size() == known) {  // no link touches it
    Reset();
    return {Verdict::kEnds, X_WB_now};
  }
  return {Verdict::kGoesOn, X_WB_now};
}

}  // namespace cwm::perception
