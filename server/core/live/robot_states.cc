#include "server/core/live/robot_states.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "collision/robot/kinematics.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

using collision::JointKind;
using collision::RobotModel;
using perception::Stamp;
using perception::StateSource;
using std::chrono::nanoseconds;

// chosen: the newest speed is that over so long, so that noise of positions and of stamps is small
// against it: 1e-4 rad are 0.01 rad/s.
constexpr std::chrono::milliseconds kSpeedTime{10};

double Seconds(nanoseconds duration) { return std::chrono::duration<double>(duration).count(); }

// The change of a variable from one state to the next.
double Change(const RobotModel& model, int variable, double from, double to) {
  const collision::Variable& of = model.variables[static_cast<std::size_t>(variable)];
  const JointKind kind = model.links[static_cast<std::size_t>(of.link)].kind;
  const bool is_whole_turn =
      kind == JointKind::kContinuous || (kind == JointKind::kPlanar && of.component == 2);
  return is_whole_turn ? std::remainder(to - from, 2 * std::numbers::pi) : to - from;
}

constexpr int kFirstOfQuaternion = 3;

// Two quaternions of opposite signs are the same rotation: `to` gets the sign of `from`. The
// components between the two are then those of a rotation between them, once they are normalised.
void AlignQuaternions(const RobotModel& model, std::span<const int> variables,
                      std::span<const double> from, std::span<double> to) {
  for (std::size_t i = 0; i + 3 < variables.size(); ++i) {
    const collision::Variable& of = model.variables[static_cast<std::size_t>(variables[i])];
    const JointKind kind = model.links[static_cast<std::size_t>(of.link)].kind;
    if (kind != JointKind::kFloating || of.component != kFirstOfQuaternion) continue;
    if (variables[i + 3] != variables[i] + 3) continue;  // not all four are told, in their order
    double dot = 0;
    for (std::size_t k = i; k < i + 4; ++k) dot += from[k] * to[k];
    for (std::size_t k = i; dot < 0 && k < i + 4; ++k) to[k] = -to[k];
  }
}

Pose Moved(const Pose& X_WF, const perception::SpatialVelocity& V_WF, double duration_s) {
  const double speed_rad_s = V_WF.angular_W_rad_s.norm();
  Pose moved = X_WF;
  moved.translation() += V_WF.linear_W_m_s * duration_s;
  if (speed_rad_s > 0) {
    moved.linear() = Eigen::AngleAxisd(speed_rad_s * duration_s, V_WF.angular_W_rad_s / speed_rad_s)
                         .toRotationMatrix() *
                     X_WF.linear();
  }
  return moved;
}

// Sets the told variables at `late` after `to`, moving as from `from` to `to`.
void Continue(const RobotModel& model, std::span<const int> variables,
              const StampedRobotState& from, const StampedRobotState& to, nanoseconds late,
              RobotStateAt& at) {
  const double span_s = Seconds(to.stamp - from.stamp), late_s = Seconds(late);
  std::vector<double> target = to.values;
  AlignQuaternions(model, variables, from.values, target);
  for (std::size_t i = 0; i < variables.size(); ++i) {
    const auto variable = static_cast<std::size_t>(variables[i]);
    const double change = Change(model, variables[i], from.values[i], target[i]);
    at.speeds_per_s[variable] = change / span_s;
    at.values[variable] = target[i] + at.speeds_per_s[variable] * late_s;
  }
  if (from.X_WB.has_value() && to.X_WB.has_value()) {
    at.V_WB = perception::VelocityBetween(*from.X_WB, *to.X_WB, span_s);
    at.X_WB = Moved(*to.X_WB, at.V_WB, late_s);
  } else if (to.X_WB.has_value()) {
    at.X_WB = *to.X_WB;
  }
}

void Hold(std::span<const int> variables, const StampedRobotState& state, RobotStateAt& at) {
  for (std::size_t i = 0; i < variables.size(); ++i) {
    at.values[static_cast<std::size_t>(variables[i])] = state.values[i];
  }
  if (state.X_WB.has_value()) at.X_WB = *state.X_WB;
}

// True if nothing moved from one state to the other.
bool IsAtRest(const StampedRobotState& from, const StampedRobotState& to) {
  const bool is_base_at_rest = from.X_WB.has_value() == to.X_WB.has_value() &&
                               (!from.X_WB.has_value() || from.X_WB->matrix() == to.X_WB->matrix());
  return from.values == to.values && is_base_at_rest;
}

// Sets the told variables and the base at the stamp; false, with a reason, if they are not known.
bool SetAt(const RobotModel& model, std::span<const int> variables,
           const std::deque<StampedRobotState>& states, Stamp stamp, RobotStateAt& at) {
  const auto after = std::ranges::lower_bound(states, stamp, {}, &StampedRobotState::stamp);
  const auto fail = [&](const char* reason) {
    if (at.reason.empty()) at.reason = reason;
    return false;
  };
  if (after != states.end()) {
    if (after->stamp == stamp && states.size() == 1) {
      Hold(variables, *after, at);
      return true;
    }
    if (after == states.begin() && after->stamp != stamp) return fail("ROBOT_STATE_MISSING");
    const auto to = after == states.begin() ? after + 1 : after;
    const StampedRobotState& from = *(to - 1);
    const bool is_known = to->stamp == stamp || from.stamp == stamp || IsAtRest(from, *to) ||
                          to->stamp - from.stamp <= RobotStates::kMaxGap;
    if (!is_known) return fail("ROBOT_STATE_STALE");
    Continue(model, variables, from, *to, stamp - to->stamp, at);
    return true;
  }
  const StampedRobotState& newest = states.back();
  const nanoseconds late = stamp - newest.stamp;
  at.late = std::max(at.late, late);
  if (late > RobotStates::kMaxExtrapolation) return fail("ROBOT_STATE_STALE");
  if (states.size() == 1) {
    Hold(variables, newest, at);
    at.source = StateSource::kHeld;
    return true;
  }
  const auto beyond =
      std::ranges::upper_bound(states, newest.stamp - kSpeedTime, {}, &StampedRobotState::stamp);
  const auto from = beyond == states.begin() ? beyond : beyond - 1;
  Continue(model, variables, *from, newest, late, at);
  if (at.source == StateSource::kInterpolated) at.source = StateSource::kExtrapolated;
  return true;
}

// The place of a stamp in states that are ordered by it; empty if it is known already.
std::optional<std::deque<StampedRobotState>::iterator> PlaceOf(
    std::deque<StampedRobotState>& states, Stamp stamp) {
  const auto at = std::ranges::lower_bound(states, stamp, {}, &StampedRobotState::stamp);
  if (at != states.end() && at->stamp == stamp) return std::nullopt;
  return at;
}

absl::Status CheckStamps(std::span<const StampedRobotState> states,
                         const std::deque<StampedRobotState>& known, Stamp now) {
  std::optional<Stamp> newest;
  if (!known.empty()) newest = known.back().stamp;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Stamp stamp = states[i].stamp;
    const auto refuse = [&](nanoseconds by, const char* rule) {
      return InvalidField(absl::StrCat("states.stamps[", i, "]"),
                          absl::StrFormat("is %.3f s %s", Seconds(by), rule));
    };
    if (stamp > now + RobotStates::kMaxFuture) {
      return refuse(stamp - now, "after the server's clock, must be at most 1 s after it");
    }
    if (newest.has_value() && stamp < *newest - RobotStates::kKeptTime) {
      return refuse(*newest - stamp, "before the newest state, must be at most 2 s before it");
    }
    newest = std::max(newest.value_or(stamp), stamp);
  }
  return absl::OkStatus();
}

}  // namespace

std::vector<perception::LinkAtStamp> LinksAt(const RobotModel& model, const RobotStateAt& state) {
  constexpr double kStep_s = 1e-3;  // chosen: turns of 1e-3 rad are exact to 1e-10
  std::vector<double> next = state.values;
  for (std::size_t i = 0; i < next.size(); ++i) next[i] += kStep_s * state.speeds_per_s[i];
  std::vector<Pose> X_WL(model.links.size()), X_WL_next(model.links.size());
  collision::LinkPoses(model, state.X_WB, state.values, X_WL);
  collision::LinkPoses(model, Moved(state.X_WB, state.V_WB, kStep_s), next, X_WL_next);
  std::vector<perception::LinkAtStamp> links;
  links.reserve(X_WL.size());
  for (std::size_t i = 0; i < X_WL.size(); ++i) {
    links.push_back({X_WL[i], perception::VelocityBetween(X_WL[i], X_WL_next[i], kStep_s)});
  }
  return links;
}

const RobotStates::Robot* RobotStates::Find(const collision::WorldRobot& robot) const {
  const auto found = robots_.find(robot.name);
  const bool is_same =
      found != robots_.end() && found->second.create_revision == robot.create_revision;
  return is_same ? &found->second : nullptr;
}

RobotStates::Track& RobotStates::TrackOf(Robot& robot, std::span<const int> variables) {
  for (Track& track : robot.tracks) {
    if (std::ranges::equal(track.variables, variables)) return track;
  }
  std::erase_if(robot.tracks, [&](const Track& track) {
    return std::ranges::find_first_of(track.variables, variables) != track.variables.end();
  });
  return robot.tracks.emplace_back(Track{.variables = {variables.begin(), variables.end()}});
}

absl::StatusOr<RobotStates::Added> RobotStates::Add(const collision::WorldRobot& robot,
                                                    std::span<const int> variables,
                                                    std::span<const StampedRobotState> states,
                                                    Stamp now) {
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (states[i].values.size() == variables.size()) continue;
    return InvalidField(
        "states.rows",
        absl::StrCat("row ", i, " has ", states[i].values.size(), " values, must have ",
                     variables.size(), ", one for each variable that is told of the robot"));
  }
  Added added;
  if (states.empty()) return added;
  const std::lock_guard lock(mutex_);
  Robot& of = robots_[robot.name];
  if (of.robot == nullptr || of.create_revision != robot.create_revision) {
    of = {.create_revision = robot.create_revision, .robot = robot.robot};
  }
  Track& track = TrackOf(of, variables);
  if (now - track.arrived > kSilentTime) track.states.clear();
  if (absl::Status checked = CheckStamps(states, track.states, now); !checked.ok()) {
    if (track.states.empty())
      std::erase_if(of.tracks, [](const Track& t) { return t.states.empty(); });
    return checked;
  }
  track.arrived = now;
  std::optional<Stamp> newest;
  if (!track.states.empty()) newest = track.states.back().stamp;
  for (const StampedRobotState& state : states) {
    const auto place = PlaceOf(track.states, state.stamp);
    const bool is_too_old = track.states.size() >= kMaxCount && place == track.states.begin();
    if (!place.has_value() || is_too_old) {
      ++added.ignored;
      continue;
    }
    ++added.taken;
    track.states.insert(*place, state);
    const Stamp oldest_kept = track.states.back().stamp - kKeptTime;
    while (track.states.size() > kMaxCount || track.states.front().stamp < oldest_kept) {
      track.states.pop_front();
    }
  }
  if (!newest.has_value() || track.states.back().stamp > *newest) track.is_taken = false;
  return added;
}

RobotStateAt RobotStates::StateAt(const collision::WorldRobot& robot, Stamp stamp) const {
  RobotStateAt at{.source = StateSource::kInterpolated,
                  .values = robot.state,
                  .speeds_per_s = std::vector<double>(robot.state.size()),
                  .X_WB = robot.X_WB};
  bool is_known = false, is_told = false;
  {
    const std::lock_guard lock(mutex_);
    const Robot* const of = Find(robot);
    for (std::size_t i = 0; of != nullptr && i < of->tracks.size(); ++i) {
      const Track& track = of->tracks[i];
      if (stamp - track.states.back().stamp > kSilentTime) continue;
      const bool is_set = SetAt(robot.model(), track.variables, track.states, stamp, at);
      is_known = is_set && (is_known || !is_told);
      is_told = true;
    }
  }
  if (is_known) return at;
  return {.source = StateSource::kMissing,
          .reason = is_told ? std::move(at.reason) : "ROBOT_STATE_MISSING",
          .late = at.late};
}

bool RobotStates::IsTold(const collision::WorldRobot& robot, Stamp stamp) const {
  const std::lock_guard lock(mutex_);
  const Robot* const of = Find(robot);
  return of != nullptr && std::ranges::any_of(of->tracks, [&](const Track& track) {
           return stamp - track.states.back().stamp <= kSilentTime;
         });
}

bool RobotStates::Awaits(Stamp stamp) const {
  const std::lock_guard lock(mutex_);
  const auto awaits = [stamp](const Track& track) {
    const nanoseconds late = stamp - track.states.back().stamp;
    return late > nanoseconds::zero() && late <= kMaxGap;
  };
  return std::ranges::any_of(
      robots_, [&](const auto& robot) { return std::ranges::any_of(robot.second.tracks, awaits); });
}

void RobotStates::Forget(const std::string& robot) {
  const std::lock_guard lock(mutex_);
  robots_.erase(robot);
}

std::vector<collision::SetRobotState> RobotStates::TakeAll() {
  const std::lock_guard lock(mutex_);
  std::vector<collision::SetRobotState> taken;
  for (auto& [name, robot] : robots_) {
    collision::SetRobotState set{.name = name, .X_WB = {}, .joints = {}};
    bool has_news = false;
    for (Track& track : robot.tracks) {
      if (std::exchange(track.is_taken, true)) continue;
      has_news = true;
      const StampedRobotState& newest = track.states.back();
      for (std::size_t i = 0; i < track.variables.size(); ++i) {
        const auto variable = static_cast<std::size_t>(track.variables[i]);
        set.joints.values.push_back(
            {robot.robot->model->variables[variable].name, newest.values[i]});
      }
      if (newest.X_WB.has_value()) set.X_WB = newest.X_WB;
    }
    if (has_news) taken.push_back(std::move(set));
  }
  return taken;
}

bool RobotStates::LeaveToFrame(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  frame_took_ = now;
  return HasUntaken();
}

bool RobotStates::ClaimDue(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  if (now < NextWrite()) return false;
  write_claimed_ = now;
  return true;
}

std::vector<collision::Change> RobotStates::ChangesOf(
    std::span<const collision::SetRobotState> states, const collision::WorldSnapshot& world) {
  std::vector<collision::Change> changes;
  for (const collision::SetRobotState& state : states) {
    if (world.FindRobot(state.name) == nullptr) continue;
    changes.push_back({.what = state, .expected_object_revision = {}});
  }
  return changes;
}

bool RobotStates::HasUntaken() const {
  return std::ranges::any_of(robots_, [](const auto& robot) {
    return !std::ranges::all_of(robot.second.tracks, &Track::is_taken);
  });
}

std::optional<Clock::time_point> RobotStates::DueAt() const {
  const std::lock_guard lock(mutex_);
  if (!HasUntaken()) return std::nullopt;
  return NextWrite();
}

Clock::time_point RobotStates::NextWrite() const {
  return std::max(write_claimed_ + kPublishPeriod, frame_took_ + kLeftToFrames);
}

}  // namespace cwm::server
