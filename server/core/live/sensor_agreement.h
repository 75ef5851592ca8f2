// Tells by what several sensors see at rest if their poses agree, and what the pose of each should
// be.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "perception/live/sensor_alignment.h"
#include "server/core/live/live_frame.h"

namespace cwm::server {

// The comparison of one sensor's view with those of others. Values: it may run anywhere.
struct AgreementJob {
  std::shared_ptr<const perception::MeanView> subject = {};  // without depths
  std::vector<perception::StillFrame> frames = {};           // of the subject, to be averaged
  std::vector<std::shared_ptr<const perception::MeanView>> others = {};
};
struct AgreementResult {
  std::shared_ptr<const perception::MeanView> subject = {};
  // One for each of the others.
  std::vector<std::shared_ptr<const perception::MeanView>> others = {};
  std::vector<perception::ViewAlignment> alignments = {};  // of the subject
};
// Takes a tenth of a second for each of the others, or half if they contradict.
AgreementResult Compare(const AgreementJob& job);

// The sensors of one world that stand still. A sensor that comes later is compared with those that
// are trusted before its frames may change anything: they are then used at the pose at which it
// agrees with the others, within the errors of the given poses, so that one place holds for each
// thing. One that moves is not compared. Not thread safe; follows from the calls alone.
class SensorAgreement {
 public:
  // chosen: the mean of so many frames has little noise beside the warp, and takes a quarter of a
  // second.
  static constexpr std::size_t kFrames = 8;
  // chosen: calibrations change when somebody bumps a stand; comparing three sensors then takes a
  // hundredth of a core.
  static constexpr auto kPeriod = std::chrono::seconds(30);
  // chosen: a sensor without frames for so long is not waited for.
  static constexpr auto kPresentTime = std::chrono::seconds(1);
  // chosen: less than the margins of motions near things. It is told if shared surfaces lie farther
  // apart by the given poses; and a sensor is used at another pose if they do by the used ones.
  static constexpr double kMaxApart_m = 0.008;
  // chosen: each sensor is compared with so many others, the nearest.
  static constexpr std::size_t kMaxOthers = 6;

  // Takes a frame as it was compared with the world, of a sensor with this given pose.
  void Add(const perception::FrameEvidence& frame, const Pose& X_WC_given,
           const SensorCalibration& calibration);

  enum class Standing { kTrusted, kWaits, kContradicts };
  Standing StandingOf(const std::string& sensor) const;
  // The pose at which frames of the sensor with this given pose are compared with the world.
  Pose UsedPose(const std::string& sensor, const Pose& X_WC_given) const;
  // The given pose of the sensor's newest frame; empty if there was none.
  std::optional<Pose> GivenPose(const std::string& sensor) const;
  // True if the sensor's frames are used at another pose, and shared surfaces lie too far apart by
  // the given ones.
  bool IsDisplaced(const std::string& sensor) const;
  // The contradictions of a sensor in words, the greatest first.
  std::vector<std::string> ConflictsOf(const std::string& sensor) const;
  std::optional<perception::SensorPoseEstimate> EstimateOf(const std::string& sensor) const;
  // Why there is no estimate, in words; empty if there is one, or nothing to compare with.
  std::string NoteOf(const std::string& sensor) const;

  // The next comparison that is due; the caller must give its result back. One at a time.
  std::optional<AgreementJob> TakeJob();
  void Take(const AgreementResult& result);
  void PutBack(const AgreementJob& job);  // it could not run
  bool is_comparing() const { return is_comparing_; }

  void Forget(const std::string& sensor);

 private:
  struct Sensor {
    std::uint64_t order = 0;  // in which the sensors came
    Standing standing = Standing::kWaits;
    bool is_moving = false;
    perception::Stamp last = {};       // of its newest frame
    perception::MeanView header = {};  // of that frame at its given pose, without depths
    std::vector<perception::StillFrame> frames = {};
    bool is_due = false;  // `frames` are complete
    perception::Stamp collected = {};
    std::shared_ptr<const perception::MeanView> view = {};  // as compared last
    // The used pose, once it is known what the sensor shares with others; it agrees with sensors of
    // which it was known before.
    std::optional<Pose> X_WC_used = {};
    std::uint64_t used_order = 0;
  };
  // By the names of two sensors; the alignment is that of the first.
  struct Pair {
    perception::ViewAlignment alignment = {};  // at the given poses
    bool is_far_apart = false;
    bool is_contradiction = false;  // beyond the errors of the given poses
  };
  using Names = std::pair<std::string, std::string>;

  bool MustWaitFor(const Sensor& other, const Sensor& sensor) const;
  bool HasTrustedBeside(const std::string& sensor) const;
  void ForgetView(const std::string& name, Sensor& sensor);
  // Forgets what follows from the given pose of a sensor that has another one now.
  void ForgetPose(Sensor& sensor, bool is_told);
  void Judge();
  void PlaceTrusted();
  void Place(const std::string& name, Sensor& sensor);
  std::vector<perception::ViewAlignment> AlignmentsOf(const std::string& sensor) const;

  std::map<std::string, Sensor> sensors_;
  std::map<Names, Pair> pairs_;  // both orders
  std::uint64_t last_order_ = 0;
  std::uint64_t last_used_order_ = 0;
  bool is_comparing_ = false;
};

}  // namespace cwm::server
