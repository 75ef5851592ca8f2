#include "perception/live/tracked_body.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "perception/cloud/tolerances.h"
#include "perception/track/ray_classification.h"

namespace cwm::perception {
namespace {

using std::chrono::milliseconds;

// chosen: fewer expected pixels give no information about a body.
constexpr int kMinExpected_px = 24;

// chosen: shares of visible pixels that rays pass through if the body is gone, and if it is there
// but its model is larger than it. Equal odds at 0.61, as for single scans.
constexpr double kThroughIfGone = 0.9;
constexpr double kThroughIfThere = 0.25;
// chosen: one frame alone never decides, however many pixels it has: its errors are correlated.
constexpr double kMaxOddsOfFrame = 8;
constexpr double kMaxOddsOfMovingFrame = 4;  // chosen: the error of a pose lasts for some frames
constexpr double kMaxOdds = 12;
constexpr double kGone = 10;
constexpr int kMinThroughFrames = 2;
constexpr milliseconds kMinThroughTime{60};

// chosen: a share of pixels in front above which the rest of the body says little of its shift.
constexpr double kMaxInFront = 0.2;
// measured: the mean depth of a patch of 46 mm changes by 0.43 mm from frame to frame, at a noise
// of a pixel of 1.9 mm.
constexpr double kPatchShare = 0.25;
// chosen: directions that the depths of a frame determine less well, by their standard deviation,
// are left as they are: a shift of 2 mm could not be told, and errors of the model would be taken
// for one.
constexpr double kMaxShiftSigma_m = 0.001;
// chosen: smaller shifts are not worth a revision.
constexpr double kMinShift_m = 0.001;

constexpr double kMinPublished_m = 0.0003;  // chosen: of a body that moves

constexpr double kSettled_mps = 0.005;  // chosen: a hand holds still less well
constexpr double kSettled_radps = 0.05;
constexpr milliseconds kSettling{150};
constexpr milliseconds kSpeedWindow{200};

// chosen: sensors may lag each other by so much; one that is silent for longer leads no more.
constexpr milliseconds kMaxLag{200};
// chosen: another sensor leads only if it tells clearly more, so that the lead does not change with
// every hand that passes.
constexpr double kLeadFactor = 2;
constexpr milliseconds kFoundAgain{500};  // chosen: a dozen frames
// chosen: a body that left all views while it moved is not where it was seen last. Behind something
// it may be, for as long as others kept such things (Rusu, Sucan et al. 2009: 30 s).
constexpr milliseconds kMaxLost{1000};
constexpr milliseconds kMaxHidden{30'000};

double Seconds(Stamp::duration time) { return std::chrono::duration<double>(time).count(); }

Visibility VisibilityOf(const BodyEvidence& evidence) {
  const int visible = evidence.consistent + evidence.farther;
  const int informed = visible + evidence.nearer + evidence.hidden;
  if (evidence.expected < kMinExpected_px || informed < kMinVisibleShare * evidence.expected) {
    return Visibility::kStale;
  }
  return visible < kMinVisibleShare * informed ? Visibility::kOccluded : Visibility::kVisible;
}

// The least shift by which a body at rest is told to have moved.
double LeastShift_m(const FrameEvidence& frame, const KnownBody& body) {
  const double range_m = (body.X_WB.translation() - frame.X_WC.translation()).norm();
  return std::max(kMinShift_m, kGate_sigma * frame.pose_sigma.At_m(range_m));
}

// True if something came to a hot region at the body, see HotRegion::points_L.
bool HasEntered(const FrameEvidence& frame, BodyId body) {
  return std::ranges::any_of(frame.regions, [&](const HotRegion& region) {
    return region.points_L.size() >= kMinChanged_px &&
           std::ranges::binary_search(region.bodies, body);
  });
}

// True if the pose explains what came to the hot regions at the body, and the old pose does not.
bool ExplainsEntered(const FrameEvidence& frame, const KnownBody& body,
                     const std::shared_ptr<const BodySurface>& surface, const Pose& X_WB) {
  const auto placed = [&](Pose X_LB) {
    X_LB.translation() -= frame.X_WC.translation();
    return PlacedSurface{surface, X_LB};
  };
  const PlacedSurface now = placed(X_WB);
  const PlacedSurface before = placed(body.X_WB);
  const double within_m = FitGate_m(frame, X_WB);
  int count = 0;
  for (const HotRegion& region : frame.regions) {
    for (const Eigen::Vector3f& p : region.points_L) {
      const Vector3 p_L = p.cast<double>();
      count += now.Explains(p_L, within_m) && !before.Explains(p_L, within_m) ? 1 : 0;
    }
  }
  return count >= kMinChanged_px;
}

// A motion and its standard deviations: translation in metres, and rotation in metres at the lever.
struct MeasuredShift {
  Vector6 shift_m = Vector6::Zero();
  Vector6 sigma_m = Vector6::Zero();
};

// The motion that explains the depths, in the directions that they determine.
MeasuredShift ShiftOf(const BodyEvidence& evidence, double lever_m) {
  constexpr double kMinInformation = 1 / (kMaxShiftSigma_m * kMaxShiftSigma_m);
  Vector6 scale;
  scale << Vector3::Ones(), Vector3::Constant(1 / lever_m);  // of the variables
  const Matrix6 information = scale.asDiagonal() * evidence.information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> directions(information);
  Vector6 variances = Vector6::Zero();
  for (int i = 0; i < 6; ++i) {
    const double known = directions.eigenvalues()[i];
    if (known >= kMinInformation) variances[i] = 1 / known;
  }
  const Matrix6& axes = directions.eigenvectors();
  const Matrix6 covariance = axes * variances.asDiagonal() * axes.transpose();
  return {.shift_m = covariance * scale.cwiseProduct(evidence.moment),
          .sigma_m = covariance.diagonal().cwiseMax(0).cwiseSqrt()};
}

Pose Shifted(const Pose& X_WB, const Vector6& shift_m, double lever_m) {
  Pose shifted = X_WB;
  shifted.translation() += shift_m.head<3>();
  const Vector3 turn = shift_m.tail<3>() / lever_m;
  const double angle_rad = turn.norm();
  if (angle_rad > 0) {
    const Matrix3 rotation = Eigen::AngleAxisd(angle_rad, turn / angle_rad).toRotationMatrix();
    shifted.linear() = Quaternion(rotation * X_WB.linear()).normalized().toRotationMatrix();
  }
  return shifted;
}

// True if something of the body's size is in front of what is known.
bool ShowsElsewhere(const FrameEvidence& frame, int expected_px) {
  return std::ranges::any_of(frame.regions, [&](const HotRegion& region) {
    return region.nearer >= kMinVisibleShare * expected_px;
  });
}

// The quantile of Student's distribution with so many degrees of freedom that a normal one has at
// kGate_sigma = 3.
double StudentGate(std::size_t degrees) {
  constexpr std::array<double, 11> kGates = {235.8, 235.8, 19.21, 9.22, 6.62, 5.51,
                                             4.90,  4.53,  4.28,  4.09, 3.96};
  return degrees < kGates.size() ? kGates[degrees] : 3.5;
}

}  // namespace

bool TrackedBody::TakeLead(const FrameEvidence& frame, const BodyEvidence& evidence,
                           const KnownBody& body) {
  SensorEvidence& own = sensors_[frame.sensor];
  const double range_m = (body.X_WB.translation() - frame.X_WC.translation()).norm();
  const double sigma_m = frame.noise.AxialSigma_m(range_m);
  own.last = frame.stamp;
  own.information = (evidence.consistent + evidence.farther) / (sigma_m * sigma_m);
  const auto told = [&](const std::string& sensor) {
    const auto found = sensors_.find(sensor);
    const bool is_silent = found == sensors_.end() || frame.stamp - found->second.last > kMaxLag;
    return is_silent ? 0 : found->second.information;
  };
  if (leader_.empty()) leader_ = frame.sensor;
  for (const auto& [name, sensor] : sensors_) {
    if (told(name) > kLeadFactor * told(leader_)) leader_ = name;
  }
  return leader_ == frame.sensor;
}

bool TrackedBody::IsGone(const FrameEvidence& frame, const BodyEvidence& evidence,
                         SensorEvidence& sensor) {
  // A body of which nothing differs is there.
  const int passed = evidence.passed;
  const int shown = evidence.is_hot ? evidence.shown : evidence.consistent;
  if (evidence.expected < kMinExpected_px ||
      passed + shown < kMinVisibleShare * evidence.expected) {
    return false;
  }
  static const double through = std::log(kThroughIfGone / kThroughIfThere);
  static const double there = std::log((1 - kThroughIfGone) / (1 - kThroughIfThere));
  const double odds = (passed * through + shown * there) / kPointsPerIndependentSample;
  if (odds <= 0) {
    sensor.through_frames = 0;
  } else if (sensor.through_frames++ == 0) {
    sensor.through_since = frame.stamp;
  }
  const double most = frame.is_moving ? kMaxOddsOfMovingFrame : kMaxOddsOfFrame;
  sensor.gone_log_odds =
      std::clamp(sensor.gone_log_odds + std::clamp(odds, -most, most), -kMaxOdds, kMaxOdds);
  if (sensor.through_frames < kMinThroughFrames ||
      frame.stamp - sensor.through_since < kMinThroughTime) {
    return false;
  }
  double all = 0;  // what other sensors see counts as well
  for (const auto& [name, other] : sensors_) all += other.gone_log_odds;
  return all > kGone;
}

std::optional<Pose> TrackedBody::SmallShift(const FrameEvidence& frame,
                                            const BodyEvidence& evidence, const KnownBody& body,
                                            SensorEvidence& sensor) const {
  const int in_front = evidence.nearer + evidence.hidden;
  const int informed = evidence.consistent + evidence.farther + in_front;
  if (evidence.moment_pixels < kMinExpected_px || in_front > kMaxInFront * informed) {
    return std::nullopt;
  }
  const double range_m = (body.X_WB.translation() - frame.X_WC.translation()).norm();
  const double sigma_m = kPatchShare * frame.noise.AxialSigma_m(range_m);
  const MeasuredShift measured = ShiftOf(evidence, surface_->lever_m());
  if (!sensor.shift.Add(measured.shift_m, measured.sigma_m.cwiseMax(sigma_m))) return std::nullopt;
  const Pose X_WB = Shifted(body.X_WB, sensor.shift.Shift_m(), surface_->lever_m());
  sensor.shift.Reset();
  if (LargestShift_m(*surface_, body.X_WB, X_WB) < kMinShift_m) return std::nullopt;
  return X_WB;
}

// A line through the poses, by least squares.
TrackedBody::Speed TrackedBody::SpeedOfPoses() const {
  Speed speed;
  const auto count = static_cast<double>(poses_.size());
  if (count < 3) return speed;
  const Pose& X_WB_first = poses_.front().X_WB;
  double mean_time_s = 0;
  Vector6 mean = Vector6::Zero();
  std::vector<std::pair<double, Vector6>> motions;
  for (const StampedPose& pose : poses_) {
    const Eigen::AngleAxisd turn(pose.X_WB.linear() * X_WB_first.linear().transpose());
    Vector6 motion;
    motion << pose.X_WB.translation() - X_WB_first.translation(),
        surface_->lever_m() * turn.angle() * turn.axis();
    motions.emplace_back(Seconds(pose.stamp - poses_.front().stamp), motion);
    mean_time_s += motions.back().first / count;
    mean += motion / count;
  }
  double spread = 0;
  for (const auto& [time_s, motion] : motions) {
    spread += (time_s - mean_time_s) * (time_s - mean_time_s);
    speed.mean += (time_s - mean_time_s) * (motion - mean);
  }
  if (spread <= 0) return {};
  speed.mean /= spread;
  for (const auto& [time_s, motion] : motions) {
    speed.sigma += (motion - mean - (time_s - mean_time_s) * speed.mean).cwiseAbs2();
  }
  speed.sigma = (speed.sigma / (count - 2) / spread).cwiseSqrt();
  return speed;
}

// The body moves as slowly as a thing at rest may seem to, or no faster than its poses scatter.
bool TrackedBody::HasSettled() const {
  const Speed speed = SpeedOfPoses();
  const double gate = StudentGate(poses_.size() - std::min<std::size_t>(poses_.size(), 2));
  const auto is_slow = [&](int i, double limit) {
    return std::abs(speed.mean[i]) < std::max(limit, gate * speed.sigma[i]);
  };
  for (int i = 0; i < 3; ++i) {
    if (!is_slow(i, kSettled_mps) || !is_slow(i + 3, kSettled_radps * surface_->lever_m())) {
      return false;
    }
  }
  return true;
}

Pose TrackedBody::Predicted(Stamp stamp, const Pose& X_WB) const {
  if (poses_.size() < 2) return X_WB;
  const Speed speed = SpeedOfPoses();
  // A speed that the scatter of the poses explains is none: directions that the points hardly
  // determine would drift with it.
  Vector3 velocity = Vector3::Zero();
  for (int i = 0; i < 3; ++i) {
    if (std::abs(speed.mean[i]) >= kGate_sigma * speed.sigma[i]) velocity[i] = speed.mean[i];
  }
  if (poses_.size() == 2) {
    const double elapsed_s = Seconds(poses_[1].stamp - poses_[0].stamp);
    if (elapsed_s <= 0) return X_WB;
    velocity = (poses_[1].X_WB.translation() - poses_[0].X_WB.translation()) / elapsed_s;
  }
  Pose predicted = poses_.back().X_WB;
  predicted.translation() += velocity * Seconds(stamp - poses_.back().stamp);
  return predicted;
}

std::optional<Pose> TrackedBody::Rest() {
  // One refit: the mean of the poses while it settled.
  Vector3 translation = Vector3::Zero();
  Eigen::Vector4d rotation = Eigen::Vector4d::Zero();
  int count = 0;
  for (const StampedPose& pose : poses_) {
    if (pose.stamp < settles_since_) continue;
    Eigen::Vector4d q = Quaternion(pose.X_WB.linear()).coeffs();
    if (count > 0 && q.dot(rotation) < 0) q = -q;
    translation += pose.X_WB.translation();
    rotation += q;
    ++count;
  }
  facts_.motion = Motion::kAtRest;
  poses_.clear();
  for (auto& [name, sensor] : sensors_) sensor.shift.Reset();
  if (count == 0) return std::nullopt;
  Pose X_WB = Pose::Identity();
  X_WB.translation() = translation / count;
  X_WB.linear() = Quaternion(rotation.normalized()).toRotationMatrix();
  return X_WB;
}

// Takes the score of the body once at each of its rests, while nothing differs.
void TrackedBody::NoteRest(const FrameEvidence& frame, const BodyEvidence& evidence,
                           const KnownBody& body) {
  if (!rests()) knows_rest_ = false;
  const bool is_seen = facts_.visibility == Visibility::kVisible && !frame.is_moving;
  if (knows_rest_ || !rests() || evidence.is_hot || !is_seen) return;
  const PoseScore score = ScoreOf(frame, *surface_, body.X_WB);
  if (score.visible() == 0) return;
  rest_score_ = score.value();
  knows_rest_ = true;
}

// The motion goes on or ends. Returns the pose to publish.
std::optional<Pose> TrackedBody::Follow(Stamp stamp, const Pose& X_WB,
                                        const std::optional<Pose>& fit) {
  poses_.push_back({stamp, fit.value_or(X_WB)});
  while (poses_.size() > 2 && stamp - poses_[1].stamp >= kSpeedWindow) poses_.pop_front();
  const bool knows_speed = stamp - poses_.front().stamp >= kSettling / 2;
  if (facts_.motion == Motion::kMoving) {
    if (knows_speed && HasSettled()) {
      facts_.motion = Motion::kSettling;
      settles_since_ = stamp;
    }
  } else if (!HasSettled()) {
    facts_.motion = Motion::kMoving;
  } else if (stamp - settles_since_ >= kSettling) {
    return Rest();
  }
  if (!fit || facts_.motion != Motion::kMoving) return std::nullopt;
  if (LargestShift_m(*surface_, X_WB, *fit) < kMinPublished_m) return std::nullopt;
  return fit;
}

TrackedBody::Outcome TrackedBody::Update(const FrameEvidence& frame, const BodyEvidence& evidence,
                                         const KnownBody& body,
                                         std::span<const PlacedSurface> supports, bool is_touched) {
  if (surface_ == nullptr || &surface_->model() != body.model.get()) {
    *this = TrackedBody();
    surface_ = std::make_shared<const BodySurface>(body.model);
  }
  SensorEvidence& sensor = sensors_[frame.sensor];
  sensor.visibility = VisibilityOf(evidence);
  JoinVisibility();
  const bool leads = TakeLead(frame, evidence, body);
  // At another pose its displacement at rest is learnt anew.
  if (sensor.X_WB.matrix() != body.X_WB.matrix()) sensor.shift.Reset();
  sensor.X_WB = body.X_WB;
  NoteRest(frame, evidence, body);
  const bool follows_poses = body.kind == KnownBody::Kind::kObject;
  std::optional<Pose> fit;
  const double least_px = evidence.MinChanged_px();
  // Points in front never pull a pose, unless they can only be the body itself.
  const bool is_nearer = !is_touched && evidence.nearer >= least_px;
  // A moving sensor sees bodies from new sides, where models often lack something.
  const bool may_be_displaced = frame.is_moving
                                    ? evidence.farther >= least_px && HasEntered(frame, body.id)
                                    : evidence.IsSeenThrough() || is_nearer;
  const bool is_displaced = evidence.is_hot && may_be_displaced;
  const bool is_seen_through =
      evidence.passed > evidence.shown ||
      (frame.is_moving ? evidence.farther : evidence.beyond) > evidence.consistent;
  if (follows_poses && (rests() ? is_displaced : leads)) {
    const std::vector<Eigen::Vector3f> points_L =
        OwnPoints(evidence, supports, FitGate_m(frame, body.X_WB));
    const Pose X_WB_guess = Predicted(frame.stamp, body.X_WB);
    if (!rests()) {
      fit = FitPose(frame, points_L, *surface_, rest_score_, body.X_WB, X_WB_guess, FitFor::kGoOn);
    }
    // It moved otherwise than predicted, or begins to move.
    if (!fit && (rests() || is_seen_through)) {
      fit = FitPose(frame, points_L, *surface_, rest_score_, body.X_WB, X_WB_guess, FitFor::kStart);
    }
    if (!fit && is_seen_through) fit = FindInRegions(frame, *surface_, rest_score_, body.X_WB);
  }
  if (fit && frame.is_moving && rests() && !ExplainsEntered(frame, body, surface_, *fit)) {
    fit.reset();
  }
  if (fit) last_fit_ = frame.stamp;
  Outcome outcome;
  if (!rests()) {
    // Without a fit all of it that is seen agrees with its pose, or it is lost.
    const bool is_followed = fit.has_value() || !is_seen_through;
    if (leads && is_followed && sensor.visibility == Visibility::kVisible) {
      outcome.X_WB = Follow(frame.stamp, body.X_WB, fit);
    }
  } else if (fit && !leads) {
    outcome.seen_at = fit;
  } else if (fit && LargestShift_m(*surface_, body.X_WB, *fit) >= LeastShift_m(frame, body)) {
    facts_.motion = Motion::kMoving;
    poses_.assign({{frame.stamp, *fit}});
    outcome.X_WB = fit;
  } else if (follows_poses && !is_touched) {
    outcome.X_WB = SmallShift(frame, evidence, body, sensor);
    if (!leads) outcome.X_WB.reset();
  }
  if (!outcome.X_WB) {
    // A body that moves may be ahead of where it is looked for, and be found again.
    const bool may_be_found = !rests() && frame.stamp - last_fit_ < kFoundAgain &&
                              ShowsElsewhere(frame, evidence.expected);
    const bool is_gone = IsGone(frame, evidence, sensor) && !may_be_found;
    outcome.is_gone = is_gone || IsLostForLong(frame.stamp);
  }
  return outcome;
}

std::optional<Pose> TrackedBody::FitCarried(const FrameEvidence& frame,
                                            const BodyEvidence& evidence, const KnownBody& body,
                                            std::span<const PlacedSurface> supports) const {
  const double within_m = FitGate_m(frame, body.X_WB);
  return FitPose(frame, OwnPoints(evidence, supports, within_m), *surface_, rest_score_, body.X_WB,
                 body.X_WB, FitFor::kGoOn);
}

void TrackedBody::Carry(const FrameEvidence& frame, const BodyEvidence* evidence,
                        const std::string& carried_by, bool has_moved) {
  if (!std::exchange(is_carried_, true)) {
    poses_.clear();
    lost_since_.reset();
    for (auto& [name, sensor] : sensors_) sensor = {.visibility = sensor.visibility};
  }
  sensors_[frame.sensor].visibility =
      evidence == nullptr ? Visibility::kStale : VisibilityOf(*evidence);
  JoinVisibility();
  if (has_moved) last_carried_ = frame.stamp;
  facts_.motion = frame.stamp - last_carried_ < kSettling ? Motion::kMoving : Motion::kAtRest;
  facts_.carried_by = carried_by;
}

void TrackedBody::LetGo(Stamp stamp, const Pose& X_WB, bool is_lost) {
  is_carried_ = false;
  facts_.carried_by.clear();
  const bool is_seen = facts_.visibility == Visibility::kVisible;
  facts_.motion = is_lost ? Motion::kMoving : is_seen ? Motion::kSettling : Motion::kAtRest;
  poses_.assign({{stamp, X_WB}});
  settles_since_ = stamp;
  last_fit_ = stamp;
}

bool TrackedBody::IsLostForLong(Stamp stamp) {
  if (facts_.visibility != Visibility::kLost) {
    lost_since_.reset();
    return false;
  }
  if (!lost_since_) lost_since_ = stamp;
  const bool is_hidden = std::ranges::any_of(
      sensors_, [](const auto& entry) { return entry.second.visibility == Visibility::kOccluded; });
  return stamp - *lost_since_ >= (is_hidden ? kMaxHidden : kMaxLost);
}

TrackedBody::Outcome TrackedBody::OutOfView(const FrameEvidence& frame) {
  const auto sensor = sensors_.find(frame.sensor);
  if (sensor == sensors_.end()) return {};
  sensor->second.visibility = Visibility::kStale;
  JoinVisibility();
  return {.is_gone = IsLostForLong(frame.stamp)};
}

void TrackedBody::ForgetSensor(const std::string& sensor) {
  sensors_.erase(sensor);
  JoinVisibility();
}

// A body is visible if any sensor sees it, else hidden if any knows it to be hidden.
void TrackedBody::JoinVisibility() {
  facts_.visibility = Visibility::kStale;
  for (const auto& [name, sensor] : sensors_) {
    if (sensor.visibility == Visibility::kVisible) facts_.visibility = Visibility::kVisible;
    if (sensor.visibility == Visibility::kOccluded && facts_.visibility != Visibility::kVisible) {
      facts_.visibility = Visibility::kOccluded;
    }
  }
  const bool is_seen = facts_.visibility == Visibility::kVisible;
  if (!is_seen && !rests() && !is_carried_) facts_.visibility = Visibility::kLost;
}

}  // namespace cwm::perception
