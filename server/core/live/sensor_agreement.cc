#include "server/core/live/sensor_agreement.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace cwm::server {
namespace {

using perception::MeanView;
using perception::ViewAlignment;

bool IsSamePose(const Pose& a, const Pose& b) { return a.matrix() == b.matrix(); }

// True if points a metre before a sensor move by more than the world takes for noise.
bool IsFarFrom(const Pose& X_WC_a, const Pose& X_WC_b) {
  const perception::Vector6 twist = perception::TwistBetween(X_WC_a, X_WC_b);
  return std::hypot(twist.head<3>().norm(), twist.tail<3>().norm()) > SensorAgreement::kMaxApart_m;
}

// True if the views differ by more than the errors of their comparison explain.
bool Differ(const ViewAlignment& alignment, const MeanView& sensor, const MeanView& other) {
  const auto exact = [](const MeanView& view) {
    MeanView pose;
    pose.X_WC = view.X_WC;
    pose.pose_sigma_m = pose.pose_sigma_rad = 0;
    return pose;
  };
  return perception::Contradicts(alignment, exact(sensor), exact(other));
}

// True if they also lie apart by more than the world takes for noise.
bool IsFarApart(const ViewAlignment& alignment, const MeanView& sensor, const MeanView& other) {
  return alignment.is_aligned && alignment.apart_m > SensorAgreement::kMaxApart_m &&
         Differ(alignment, sensor, other);
}

std::string DirectionName(const perception::Vector6& twist) {
  const bool is_turn = twist.tail<3>().norm() > twist.head<3>().norm();
  const Vector3 axis = (is_turn ? twist.tail<3>() : twist.head<3>()).normalized();
  return absl::StrFormat("%s (%.2f, %.2f, %.2f)", is_turn ? "turns about" : "shifts along",
                         axis.x(), axis.y(), axis.z());
}

}  // namespace

AgreementResult Compare(const AgreementJob& job) {
  auto subject = std::make_shared<MeanView>(*job.subject);
  subject->depth_m = perception::MeanAtRest(job.frames, subject->camera, subject->noise);
  AgreementResult result{.subject = subject, .others = job.others};
  for (const auto& other : job.others) {
    result.alignments.push_back(perception::AlignViews(*subject, *other));
  }
  return result;
}

void SensorAgreement::Add(const perception::FrameEvidence& frame, const Pose& X_WC_given,
                          const SensorCalibration& calibration) {
  const auto [found, is_new] = sensors_.try_emplace(frame.sensor);
  Sensor& sensor = found->second;
  if (is_new) sensor.order = ++last_order_;
  const bool is_other_pose = is_new || !IsSamePose(sensor.header.X_WC, X_WC_given);
  const bool is_other = is_other_pose || sensor.header.camera != frame.camera ||
                        sensor.header.pose_sigma_m != calibration.pose_sigma_m ||
                        sensor.header.pose_sigma_rad != calibration.pose_sigma_rad;
  sensor.is_moving = !is_new && is_other_pose;
  sensor.last = frame.stamp;
  if (is_other) {
    ForgetView(frame.sensor, sensor);
    if (is_other_pose) ForgetPose(sensor, !frame.may_move);
    sensor.header = {.sensor = frame.sensor,
                     .X_WC = X_WC_given,
                     .camera = frame.camera,
                     .noise = frame.noise,
                     .pose_sigma_m = calibration.pose_sigma_m,
                     .pose_sigma_rad = calibration.pose_sigma_rad};
    sensor.standing = sensor.is_moving ? Standing::kTrusted : Standing::kWaits;
  }
  if (sensor.is_moving) return;
  if (sensor.standing == Standing::kWaits && !HasTrustedBeside(frame.sensor)) {
    sensor.standing = Standing::kTrusted;
  }
  const bool is_old = sensor.view == nullptr || frame.stamp - sensor.collected >= kPeriod;
  if (sensors_.size() < 2 || sensor.is_due || !is_old) return;
  sensor.frames.push_back({.image = frame.image, .classes = frame.classes});
  if (sensor.frames.size() < kFrames) return;
  sensor.is_due = true;
  sensor.collected = frame.stamp;
}

void SensorAgreement::ForgetView(const std::string& name, Sensor& sensor) {
  sensor.frames.clear();
  sensor.is_due = false;
  sensor.view.reset();
  std::erase_if(pairs_, [&](const auto& entry) {
    return entry.first.first == name || entry.first.second == name;
  });
}

// The others keep the places that agree with where a camera that may move stood. A pose that was told
// anew, of the sensor that all others agree with, is meant to move what it sees.
void SensorAgreement::ForgetPose(Sensor& sensor, bool is_told) {
  const bool is_first =
      sensor.X_WC_used.has_value() && std::ranges::none_of(sensors_, [&](const auto& entry) {
        const Sensor& other = entry.second;
        return other.X_WC_used && other.used_order < sensor.used_order;
      });
  sensor.X_WC_used.reset();
  if (!is_first || !is_told) return;
  for (auto& named : sensors_) named.second.X_WC_used.reset();
  PlaceTrusted();
}

// True if the other sensor may tell about this one, now or soon.
bool SensorAgreement::MustWaitFor(const Sensor& other, const Sensor& sensor) const {
  if (other.is_moving || other.standing != Standing::kTrusted) return false;
  return other.view != nullptr || sensor.last - other.last < kPresentTime;
}

bool SensorAgreement::HasTrustedBeside(const std::string& sensor) const {
  const Sensor& own = sensors_.at(sensor);
  return std::ranges::any_of(sensors_, [&](const auto& entry) {
    return entry.first != sensor && MustWaitFor(entry.second, own);
  });
}

SensorAgreement::Standing SensorAgreement::StandingOf(const std::string& sensor) const {
  const auto found = sensors_.find(sensor);
  return found == sensors_.end() ? Standing::kTrusted : found->second.standing;
}

Pose SensorAgreement::UsedPose(const std::string& sensor, const Pose& X_WC_given) const {
  const auto found = sensors_.find(sensor);
  const bool is_known = found != sensors_.end() && found->second.X_WC_used.has_value() &&
                        IsSamePose(found->second.header.X_WC, X_WC_given);
  return is_known ? *found->second.X_WC_used : X_WC_given;
}

std::optional<Pose> SensorAgreement::GivenPose(const std::string& sensor) const {
  const auto found = sensors_.find(sensor);
  return found == sensors_.end() ? std::nullopt : std::optional(found->second.header.X_WC);
}

bool SensorAgreement::IsDisplaced(const std::string& sensor) const {
  const auto found = sensors_.find(sensor);
  if (found == sensors_.end() || !found->second.X_WC_used) return false;
  if (IsSamePose(*found->second.X_WC_used, found->second.header.X_WC)) return false;
  return std::ranges::any_of(pairs_, [&](const auto& entry) {
    return entry.first.first == sensor && entry.second.is_far_apart;
  });
}

std::optional<AgreementJob> SensorAgreement::TakeJob() {
  if (is_comparing_) return std::nullopt;
  for (auto& named : sensors_) {
    Sensor& sensor = named.second;
    if (!sensor.is_due) continue;
    // The first one of a world has nobody to be compared with, but is there for the next ones.
    const bool is_too_early = std::ranges::any_of(sensors_, [&](const auto& entry) {
      const Sensor& other = entry.second;
      return other.order < sensor.order && other.view == nullptr && MustWaitFor(other, sensor);
    });
    if (is_too_early) continue;
    AgreementJob job{.subject = std::make_shared<const MeanView>(sensor.header),
                     .frames = std::move(sensor.frames)};
    sensor.frames.clear();
    sensor.is_due = false;
    for (const auto& [other_name, other] : sensors_) {
      if (other_name != named.first && other.view != nullptr) job.others.push_back(other.view);
    }
    const Vector3 p_W = sensor.header.X_WC.translation();
    std::ranges::stable_sort(job.others, {}, [&](const auto& other) {
      return (other->X_WC.translation() - p_W).norm();
    });
    if (job.others.size() > kMaxOthers) job.others.resize(kMaxOthers);
    is_comparing_ = true;
    return job;
  }
  return std::nullopt;
}

void SensorAgreement::Take(const AgreementResult& result) {
  is_comparing_ = false;
  const std::string& name = result.subject->sensor;
  const auto found = sensors_.find(name);
  const auto is_current = [](const Sensor& sensor, const MeanView& view) {
    return IsSamePose(sensor.header.X_WC, view.X_WC) && sensor.header.camera == view.camera;
  };
  if (found == sensors_.end() || !is_current(found->second, *result.subject)) return;
  found->second.view = result.subject;
  for (std::size_t i = 0; i < result.others.size(); ++i) {
    const MeanView& other = *result.others[i];
    const auto beside = sensors_.find(other.sensor);
    if (beside == sensors_.end() || !is_current(beside->second, other)) continue;
    const ViewAlignment& alignment = result.alignments[i];
    const bool is_contradiction = perception::Contradicts(alignment, *result.subject, other);
    const bool is_far_apart = is_contradiction || IsFarApart(alignment, *result.subject, other);
    pairs_[{name, other.sensor}] = {alignment, is_far_apart, is_contradiction};
    pairs_[{other.sensor, name}] = {perception::Reversed(alignment, *result.subject, other),
                                    is_far_apart, is_contradiction};
  }
  if (found->second.standing == Standing::kWaits) found->second.standing = Standing::kTrusted;
  Judge();
}

void SensorAgreement::PutBack(const AgreementJob& job) {
  is_comparing_ = false;
  const auto found = sensors_.find(job.subject->sensor);
  if (found == sensors_.end() || !IsSamePose(found->second.header.X_WC, job.subject->X_WC)) return;
  found->second.frames = job.frames;
  found->second.is_due = true;
}

// Whoever contradicts most others is not trusted; of two, the one that came later.
void SensorAgreement::Judge() {
  std::set<std::string> left_out;
  for (;;) {
    std::string worst;
    std::pair<int, std::uint64_t> most;
    for (const auto& [name, sensor] : sensors_) {
      if (sensor.view == nullptr || left_out.contains(name)) continue;
      int count = 0;
      for (const auto& [names, pair] : pairs_) {
        const bool counts =
            names.first == name && pair.is_contradiction && !left_out.contains(names.second);
        count += counts ? 1 : 0;
      }
      const std::pair<int, std::uint64_t> badness{count, sensor.order};
      if (count == 0 || badness < most) continue;
      most = badness;
      worst = name;
    }
    if (worst.empty()) break;
    left_out.insert(worst);
  }
  for (auto& [name, sensor] : sensors_) {
    if (sensor.view == nullptr) continue;
    sensor.standing = left_out.contains(name) ? Standing::kContradicts : Standing::kTrusted;
    if (left_out.contains(name)) sensor.X_WC_used.reset();
  }
  PlaceTrusted();
}

// One after the other, in the order in which they came.
void SensorAgreement::PlaceTrusted() {
  std::vector<std::pair<const std::string, Sensor>*> trusted;
  for (auto& named : sensors_) {
    const Sensor& sensor = named.second;
    if (sensor.view != nullptr && sensor.standing == Standing::kTrusted) trusted.push_back(&named);
  }
  std::ranges::sort(trusted, {}, [](const auto* named) { return named->second.order; });
  for (auto* const named : trusted) Place(named->first, named->second);
}

// A given pose that agrees with the others stays, since a comparison has errors as well. Another pose
// makes a sensor learn anew what it sees: a used pose that still agrees stays, too.
void SensorAgreement::Place(const std::string& name, Sensor& sensor) {
  std::vector<ViewAlignment> alignments;
  bool differs = false;
  for (const auto& [names, pair] : pairs_) {
    if (names.first != name || pair.is_contradiction) continue;
    const Sensor& other = sensors_.at(names.second);
    if (!other.X_WC_used || (sensor.X_WC_used && other.used_order > sensor.used_order)) continue;
    const Pose X_WW = *other.X_WC_used * other.header.X_WC.inverse();
    alignments.push_back(perception::WithOtherMoved(pair.alignment, sensor.header, X_WW));
    differs |= Differ(alignments.back(), sensor.header, other.header);
  }
  const Pose X_WC =
      differs ? perception::MostLikelyPose(sensor.header, alignments) : sensor.header.X_WC;
  if (!sensor.X_WC_used) {
    sensor.used_order = ++last_used_order_;
    sensor.X_WC_used = X_WC;
  } else if (IsFarFrom(*sensor.X_WC_used, X_WC)) {
    sensor.X_WC_used = X_WC;
  }
}

std::vector<std::string> SensorAgreement::ConflictsOf(const std::string& sensor) const {
  std::vector<std::pair<double, std::string>> found;
  for (const auto& [names, pair] : pairs_) {
    if (names.first != sensor || !pair.is_far_apart) continue;
    const double apart_m = pair.alignment.apart_m;
    found.emplace_back(
        -apart_m,
        pair.alignment.is_aligned
            ? absl::StrFormat("what it and the sensor \"%s\" both see lies %.1f mm apart, %s the "
                              "errors of their poses",
                              names.second, 1e3 * apart_m,
                              pair.is_contradiction ? "more than" : "within")
            : absl::StrFormat("it sees surfaces in space that the sensor \"%s\" sees "
                              "through, by %.1f mm and more",
                              names.second, 1e3 * apart_m));
  }
  std::ranges::sort(found);
  std::vector<std::string> words;
  for (auto& [size, text] : found) words.push_back(std::move(text));
  return words;
}

std::vector<ViewAlignment> SensorAgreement::AlignmentsOf(const std::string& sensor) const {
  std::vector<ViewAlignment> alignments;
  for (const auto& [names, pair] : pairs_) {
    if (names.first == sensor) alignments.push_back(pair.alignment);
  }
  return alignments;
}

std::optional<perception::SensorPoseEstimate> SensorAgreement::EstimateOf(
    const std::string& sensor) const {
  const auto found = sensors_.find(sensor);
  if (found == sensors_.end() || found->second.is_moving) return std::nullopt;
  return perception::EstimatePose(found->second.header, AlignmentsOf(sensor));
}

std::string SensorAgreement::NoteOf(const std::string& sensor) const {
  const auto found = sensors_.find(sensor);
  if (found == sensors_.end() || found->second.is_moving) return {};
  const std::vector<ViewAlignment> alignments = AlignmentsOf(sensor);
  if (alignments.empty()) return {};
  std::optional<perception::Vector6> undetermined;
  if (perception::EstimatePose(found->second.header, alignments, &undetermined)) return {};
  if (!undetermined) return "no pose estimate: it shares too few surfaces with other sensors";
  return absl::StrCat("no pose estimate: no surface that other sensors see too determines ",
                      DirectionName(*undetermined));
}

void SensorAgreement::Forget(const std::string& sensor) {
  const auto found = sensors_.find(sensor);
  if (found == sensors_.end()) return;
  ForgetView(sensor, found->second);
  sensors_.erase(found);
}

}  // namespace cwm::server
