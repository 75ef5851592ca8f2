// A world of a server: queries, changes, scans and events.
//
//   cwm::World world = cwm::Connect();
//   cwm::PairResult nearest = world.Distance(cwm::Sphere{0.1}, poses);
//
// Metres, radians, seconds; world z up. X_AB is the pose of frame B in frame A. Calls that fail and
// arguments that cannot be right throw cwm::Error.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cwm/changes.h"
#include "cwm/error.h"
#include "cwm/live.h"
#include "cwm/namespace.h"
#include "cwm/objects.h"
#include "cwm/queries.h"
#include "cwm/results.h"
#include "cwm/robots.h"
#include "cwm/scans.h"
#include "cwm/shapes.h"
#include "cwm/watch.h"

namespace cwm::CWM_API {

class Server;

class WorldView;

namespace internal {
struct View;
WorldView MakeView(std::shared_ptr<const View> view);
}  // namespace internal

// Restricts a list of objects.
struct ObjectFilter {
  std::vector<ObjectKind> kinds = {};  // empty: all
  std::string prefix = {};             // of the names
  // Corners of a box in the world that their bounds touch.
  std::optional<Eigen::AlignedBox3d> within = {};
  ObjectView view = ObjectView::kFull;
};

enum class ExportFormat { kMoveItScene = 1, kMoveItYaml, kGlb, kPly, kUrdf, kSdf };

// A file of another tool, and those that it refers to.
struct ExportedFile {
  std::string name;  // relative to the first file
  std::string bytes;
};
struct ExportResult {
  std::string world_uid;
  std::int64_t revision = 0;
  std::string bytes;
  std::vector<ExportedFile> files = {};
  std::vector<std::string> warnings = {};  // what the format says otherwise, or not at all

  // Writes the file to `path`, and the others beside it.
  void Save(const std::string& path) const;
};

// Queries about one world, at its newest revision or at one that is pinned. Cheap to copy, thread
// safe. Batches above the server's limits are cut, and all of them asked about one revision.
class WorldView {
 public:
  const std::string& name() const;
  // The newest revision, or the pinned one. kNotFound if nothing has made the world yet.
  std::int64_t revision() const;
  // Of this world alone: another one of the name, also after a restart of the server, has another.
  std::string uid() const;
  Server server() const;

  // The world pinned to a revision, by default the newest. A server keeps the last ones, thinned if
  // there are many in a second, and one that is used at least once a minute; else kOutOfRange
  // REVISION_COMPACTED. The first use should follow within a second.
  WorldView At(std::optional<std::int64_t> revision = {}) const;
  // The same with a timeout of every call, kDeadlineExceeded afterwards; absent: no limit. Queries
  // over a stream have none; give them a time budget.
  WorldView Within(std::optional<double> timeout_s) const;
  // The same, each of whose queries is answered as if the world had been changed so. Nobody else
  // sees it. Lists of objects show the world as it is.
  WorldView WhatIf(std::vector<Change> changes) const;
  // The same over one stream, for many small queries: each takes less time, those of several
  // threads overlap, and changes of WhatIf are sent once. A stream whose server is lost ends:
  // kUnavailable from then on.
  WorldView Stream() const;

  std::vector<Object> Objects(const ObjectFilter& filter = {}) const;  // by name
  Object Get(const std::string& name) const;
  // All that an object is made of as one mesh in its frame.
  Mesh ReadSurface(const std::string& name) const;
  Mesh ReadMesh(const std::string& hash) const;
  // Sends the mesh and returns it as its hash alone, which many queries then name. A mesh with
  // vertices is hashed by each query, and sent by the first.
  Mesh WriteMesh(const Mesh& mesh) const;
  std::vector<Robot> Robots() const;  // by name
  Robot GetRobot(const std::string& name) const;
  std::vector<PairRule> Rules() const;
  ExportResult Export(ExportFormat format, const std::string& robot = {}) const;

  // Which rows collide, and on the way which pair.
  CheckResult Check(const Subject& subject, const Rows& rows = {},
                    const QueryOptions& options = {}) const;
  // The nearest objects of each row, with signed distance, points and normal.
  PairResult Distance(const Subject& subject, const Rows& rows = {},
                      const QueryOptions& options = {}) const;
  // The contacts of each row, with depth (distance_m < 0), points and normal.
  PairResult Contacts(const Subject& subject, const Rows& rows = {},
                      const QueryOptions& options = {}) const;
  // All contacts between objects and robots of the world; of the options, max_contacts limits the
  // pairs.
  WorldContacts ContactsOfWorld(const QueryOptions& options = {}) const;
  // Whether the motions from starts[i] to ends[i] are free: certified, not sampled. Joints move
  // linearly, continuous ones the short way; of poses the origin linearly, the rotation by slerp.
  MotionResult Motions(const Subject& subject, const Rows& starts, const Rows& ends,
                       const QueryOptions& options = {}) const;
  // The same for whole paths of two rows or more, one verdict each.
  MotionResult Paths(const Subject& subject, std::span<const Rows> paths,
                     const QueryOptions& options = {}) const;
  MotionResult Path(const Subject& subject, const Rows& path,
                    const QueryOptions& options = {}) const;
  // The first hit of each ray; origins in columns, or one for all; directions of any positive
  // length.
  RayResult Rays(const Eigen::Ref<const Eigen::Matrix3Xd>& origins,
                 const Eigen::Ref<const Eigen::Matrix3Xd>& directions,
                 const QueryOptions& options = {}) const;
  // The signed distance of the world at points in columns, and its gradient.
  SampleResult Sample(const Eigen::Ref<const Eigen::Matrix3Xd>& points,
                      const QueryOptions& options = {}) const;
  // Inverse kinematics: states of the robot's group for poses X_WT of its tool. The same call gives
  // the same answer: it is bounded by steps, never by time.
  PoseResult Solve(const RobotSubject& robot, std::span<const Eigen::Isometry3d> X_WT,
                   const SolveOptions& options = {}) const;
  PoseResult Solve(const RobotSubject& robot, const Eigen::Isometry3d& X_WT,
                   const SolveOptions& options = {}) const {
    return Solve(robot, std::span<const Eigen::Isometry3d>(&X_WT, 1), options);
  }
  // Forward kinematics: poses of links, by default of all, in the order of the URDF.
  LinkPoses PosesOfLinks(const RobotSubject& robot, const Rows& states = {},
                         std::vector<std::string> links = {},
                         const QueryOptions& options = {}) const;

 protected:
  explicit WorldView(std::shared_ptr<const internal::View> view) : view_(std::move(view)) {}
  const internal::View& view() const { return *view_; }

 private:
  friend class Server;
  friend WorldView internal::MakeView(std::shared_ptr<const internal::View> view);
  std::shared_ptr<const internal::View> view_;
};

// A world with all that changes it. Writes return the revision that they made; they are sent once
// more if the server was lost, under an id by which it recognises what it did already.
class World : public WorldView {
 public:
  // Columns x y z of points, metres, NaN where the sensor saw nothing; of an organised cloud row by
  // row, see ScanOptions::height. A PCL cloud is `cloud.getMatrixXfMap(3, 4, 0)`, whose layout
  // needs no copy.
  using CloudRef = Eigen::Ref<const Eigen::Matrix3Xf, 0, Eigen::OuterStride<>>;
  IngestResult Ingest(const CloudRef& points, const ScanOptions& options = {}) const;

  // Follows the world with the frames of a running sensor.
  SensorStream StreamSensor(const SensorCalibration& calibration) const;
  // Tells where a robot stands while it moves: values of these variables; none: of all, in the
  // order of Robot::variables.
  RobotStateStream StreamRobotStates(const std::string& robot,
                                     const std::vector<std::string>& variables = {}) const;
  std::vector<Sensor> Sensors() const;  // that stream or have streamed, by name
  // Sets the pose of a sensor, absent: to its estimate; returns it. kNotFound SENSOR_UNKNOWN,
  // kFailedPrecondition NO_ESTIMATE.
  Eigen::Isometry3d SetSensorPose(const std::string& sensor,
                                  const std::optional<Eigen::Isometry3d>& X_WS) const;

  // All changes in order, or none; one revision.
  std::int64_t Apply(std::span<const Change> changes,
                     std::optional<std::int64_t> expected_revision = {}) const;
  std::int64_t Apply(std::initializer_list<Change> changes,
                     std::optional<std::int64_t> expected_revision = {}) const {
    return Apply(std::span<const Change>(changes.begin(), changes.size()), expected_revision);
  }
  std::int64_t Put(const std::string& name, const Body& body,
                   const Eigen::Isometry3d& X_WO = Eigen::Isometry3d::Identity()) const;
  std::int64_t Move(const std::string& name, const Eigen::Isometry3d& X_WO) const;
  std::int64_t Remove(const std::string& name) const;
  // At X_LO, or where the object is.
  std::int64_t Attach(const std::string& name, const std::string& robot, const std::string& link,
                      const std::vector<std::string>& touch_links = {},
                      const std::optional<Eigen::Isometry3d>& X_LO = {}) const;
  std::int64_t Detach(const std::string& name) const;
  std::int64_t Allow(const NamedThing& a, const NamedThing& b,
                     std::optional<double> expires_after_s = {}) const;
  // Ends what Allow allowed.
  std::int64_t Disallow(const NamedThing& a, const NamedThing& b) const;
  std::int64_t SetMargin(const NamedThing& a, const NamedThing& b,
                         std::optional<double> margin_m) const;
  std::int64_t SetRobotState(const std::string& robot, const JointState& joints,
                             const std::optional<Eigen::Isometry3d>& X_WB = {}) const;

  // In place of another robot of its name. kInvalidArgument names a mesh that is not there.
  LoadedRobot LoadRobot(const RobotFiles& files, const LoadOptions& options = {}) const;
  std::int64_t DeleteRobot(const std::string& name) const;

  Watcher Watch(const WatchOptions& options = {}) const;

 private:
  friend class Server;
  using WorldView::WorldView;
};

struct ConnectOptions {
  // "unix:PATH" or "HOST:PORT"; empty: $CWM_ADDR, else the Unix socket of the user's own server.
  std::string address = {};
  std::string world = "default";
  std::optional<double> timeout_s = {};  // of every call; absent: no limit
};

// A world as its server describes it.
struct WorldInfo {
  std::string name;
  std::string uid;
  std::int64_t revision = 0;
  std::int64_t object_count = 0;
  std::int64_t robot_count = 0;
  std::int64_t oldest_exact_revision = 0;  // that At can pin; later ones may be missing
  std::int64_t oldest_watch_revision = 0;  // from which a watch can go on
};

struct ServerInfo {
  std::string version;
  double uptime_s = 0;
  std::string store;
  std::map<std::string, std::string> engines = {};  // versions by name
  std::int64_t max_message_bytes = 0;
  std::int64_t max_batch_rows = 0;
  std::int64_t max_answers = 0;
};

// A connection; several worlds share one.
class Server {
 public:
  // kUnavailable if no server answers; kPermissionDenied if no address was given and another user
  // could answer in the server's place.
  explicit Server(const ConnectOptions& options = {});

  const std::string& address() const;
  ServerInfo Info() const;
  std::vector<WorldInfo> Worlds() const;  // by name
  // The world of that name, there or not: the first put, scan or load of a robot makes it.
  World GetWorld(const std::string& name = "default") const;
  // Ends the world, and its watches with kNotFound.
  void DeleteWorld(const std::string& name) const;

 private:
  friend class WorldView;
  explicit Server(std::shared_ptr<const internal::View> view) : view_(std::move(view)) {}
  std::shared_ptr<const internal::View> view_;
};

// The world of the options on a server.
World Connect(const ConnectOptions& options = {});

}  // namespace cwm::CWM_API
