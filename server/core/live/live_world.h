// A world that follows running sensors: each frame is compared with what the world holds, and what
// it changes becomes one revision.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/live/tracker.h"
#include "server/core/ingest.h"
#include "server/core/live/body_table.h"
#include "server/core/live/first_frame.h"
#include "server/core/live/gone_objects.h"
#include "server/core/live/live_commit.h"
#include "server/core/live/live_frame.h"
#include "server/core/live/lockstep.h"
#include "server/core/live/region_ingest.h"
#include "server/core/live/sensor_agreement.h"
#include "server/core/live/sensor_place.h"
#include "server/core/live/sensor_session.h"
#include "server/core/live/shape_fusion.h"
#include "server/core/world.h"

namespace cwm::server {

absl::Status SensorUnknown(const std::string& sensor);  // NOT_FOUND SENSOR_UNKNOWN

// Services of the server for all live worlds.
struct LiveServices {
  Interpreter interpret = {};
  // Runs a task beside the frames, as scans are; false if it cannot be taken now.
  std::function<bool(std::function<void()>)> run_beside = {};
  int max_threads = 1;                    // of one interpretation
  std::function<int()> threads_now = {};  // as in perception::InterpretOptions
};

class LiveWorld;

// A sensor's stream of frames. Used by one thread at a time.
class SensorStream {
 public:
  SensorStream(std::shared_ptr<LiveWorld> world, std::shared_ptr<SensorSession> session,
               std::uint64_t number);
  ~SensorStream();
  SensorStream(const SensorStream&) = delete;
  SensorStream& operator=(const SensorStream&) = delete;

  // Frames that are refused are answered by the outcome. Errors end the stream: NotFound
  // WORLD_DELETED, Aborted SENSOR_TAKEN_OVER.
  absl::StatusOr<FrameOutcome> Process(const LiveFrame& frame);
  // A frame in lockstep: Process between the two. See Lockstep.
  void BeginTurn(Lockstep::Callback begin);
  void EndTurn(Lockstep::Callback end);
  // See SensorSession::Hold.
  void Hold(MemoryCharge view) { session_->Hold(std::move(view)); }
  // Counts a frame that a newer one replaced, or that was refused before Process.
  void NoteDropped() { session_->NoteDropped(); }
  void NoteRefused() { session_->NoteRefused(); }
  // True if a frame that comes now is interpreted to tell the sensor's pose, which takes long.
  bool MustIngestFirst(bool frame_has_pose) const;
  // The camera of the sensor's earlier frames; empty if there were none.
  std::optional<perception::DepthCamera> camera() const;
  const std::shared_ptr<LiveWorld>& world() const { return world_; }

 private:
  const std::shared_ptr<LiveWorld> world_;
  const std::shared_ptr<SensorSession> session_;
  const std::uint64_t number_;
};

// Thread safe.
class LiveWorld : public std::enable_shared_from_this<LiveWorld> {
 public:
  // chosen: sensors of one world.
  static constexpr std::size_t kMaxSensors = 64;
  // chosen: what a sensor that went away saw moving is gone for so long before it is taken out of
  // the world; a stream that is open may pause longer.
  static constexpr auto kGoneTime = std::chrono::seconds(2);
  static constexpr auto kSilentTime = std::chrono::seconds(10);
  // chosen: a sensor that comes back within this time finds what it had learnt, and its stamps must
  // go on. Later it may begin anew.
  static constexpr auto kKeepTime = std::chrono::seconds(60);

  LiveWorld(std::shared_ptr<World> world, LiveServices services);

  const std::shared_ptr<World>& world() const { return world_; }

  // Begins a stream; `end` is called if it has to end. NotFound ROBOT_UNKNOWN, FailedPrecondition
  // LINK_UNKNOWN for a mount; ResourceExhausted TOO_MANY_SENSORS.
  absl::StatusOr<std::unique_ptr<SensorStream>> Open(const SensorCalibration& calibration,
                                                     EndStream end);

  // Begins to prepare the robots of the world for frames, on threads of their own. True if all are
  // prepared: frames change nothing before. A stream that is opened does this.
  bool PrepareRobots();

  std::vector<SensorStatus> Sensors() const;  // by name
  bool Has(const std::string& sensor) const;
  // NotFound SENSOR_UNKNOWN; FailedPrecondition SENSOR_ON_ROBOT for a mounted one.
  absl::Status SetSensorPose(const std::string& sensor, const Pose& X_WC);
  // The pose that other sensors suggest; empty if too little determines it.
  std::optional<Pose> EstimatedPose(const std::string& sensor) const;
  // The newest frame of each sensor, or of this one, that is newer than `number`; by number.
  std::vector<std::shared_ptr<const DisplayFrame>> FramesAfter(std::uint64_t number,
                                                               const std::string& sensor) const;

  // Forgets what belongs to sensors that are gone. Call it about twice a second. True if the view
  // of one was freed, which is much memory.
  bool ForgetGone(Clock::time_point now);
  // Ends all streams and stops interpretations: the world was deleted, or the server stops.
  void End(const absl::Status& reason);

 private:
  friend class SensorStream;

  using Session = std::shared_ptr<SensorSession>;
  using Evidence = perception::FrameEvidence;

  absl::StatusOr<FrameOutcome> Process(const Session& session, std::uint64_t stream,
                                       const LiveFrame& frame);
  RobotsSeen FindRobots(SensorComparison& comparison, const SensorCalibration& calibration,
                        const LiveFrame& frame, const SensorPlace& place, const BodyTable& table,
                        std::span<const perception::KnownBody> bodies,
                        std::span<const RobotAtFrame> robots);
  SensorPlace UsedPlace(const std::string& sensor, const SensorPlace& given) const;
  std::vector<perception::TrackChange> Track(const Evidence& evidence,
                                             const std::shared_ptr<const BodyTable>& table,
                                             std::span<const perception::KnownBody> bodies,
                                             const Session& session);
  absl::StatusOr<LiveWritten> Publish(const std::vector<perception::TrackChange>& changes,
                                      const std::string& sensor,
                                      const std::shared_ptr<const BodyTable>& table);
  void PublishFacts(const perception::StepResult& step, const BodyTable& bodies);
  // An object is seen that was gone or lost: it may be another one of its shape.
  void NoteSeenAgain(const collision::WorldObject& object, const BodyTable& bodies);
  void NoteSightings(const Evidence& evidence, const BodyTable& bodies, SensorComparison& at);
  bool IsTrusted(const Evidence& evidence, const Pose& X_WC_given,
                 const SensorCalibration& calibration, FrameOutcome& outcome);
  void StartComparison();
  void NoteShapes(const Evidence& evidence, const std::shared_ptr<const BodyTable>& table);
  void StartFusion();
  void FinishFusion(const FusionJob& job, const FrameChanges& fused);
  void ForgetAgreement(const std::string& sensor);
  void StartRegions();
  // As LiveServices::run_beside; frames in lockstep wait for the end of the task.
  bool StartBeside(std::function<void()> task);
  // True if something runs or waits beside the frames that may change what later ones see.
  bool RunsBeside() const;
  void InterpretRegion(const Session& session, const RegionJob& job);
  void ForgetMovers(SensorSession& session);
  void ClearFacts();
  std::vector<Session> Sessions() const;
  absl::Status MakeRoomForSensor();

  const std::shared_ptr<World> world_;
  const LiveServices services_;
  BodyNumbers numbers_;
  RobotShapes shapes_;
  std::stop_source stop_;
  Lockstep lockstep_;

  mutable std::mutex sensors_mutex_;  // a leaf
  std::map<std::string, Session> sessions_;
  bool has_ended_ = false;
  absl::Status end_reason_;
  bool has_facts_ = false;  // objects may have facts

  // The sequencer: what frames do one after the other.
  mutable std::mutex sequencer_;
  perception::Tracker tracker_;
  SensorAgreement agreement_;
  ShapeFusion fusion_;
  MoverObjects movers_;
  std::uint64_t last_frame_ = 0;
  struct Waiting {
    Session session;
    std::shared_ptr<const RegionJob> job;
  };
  std::deque<Waiting> regions_;
  int regions_asked_ = 0;  // waiting and running
  bool region_runs_ = false;
  GoneObjects gone_;
};

}  // namespace cwm::server
