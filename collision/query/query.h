// Batched queries to one snapshot of the world: a body of shapes at many poses, a robot in many
// states, rays, points. Results are stored in columns. The same snapshot and query give the same
// bytes on any number of threads; ties are broken by object name, then part.
//
// Margins: distances and depths are geometric and never include margins. A state collides if the
// distance of some pair is strictly less than the pair's margin. That is the margin of a pair rule,
// else the sum of the margins of the object, of the query body (or of the attached object) and of
// the request. In either case margin_sigma standard deviations of both parts' surfaces are added.
// Robots have no margins of their own, but their links may have paddings, which are added against
// the world and not among the links and attached objects of one robot. Between a querying or
// attached object and its support the margin is -support_tolerance_m, since the object stands
// there.
//
// A robot of the world is an obstacle in its current state, except to itself. Objects attached to a
// robot are part of its query body and not obstacles to it.
//
// Pairs that are allowed to collide, by the SRDF, the world or the request, are ignored by all
// queries. Rays and sampled points belong to no body, so no rule applies to them.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/kernels/pair_distance.h"
#include "collision/world/world_snapshot.h"

namespace cwm::collision {

class ProgramCache;  // spheres/program_cache.h

// Two parts of one body.
struct PartPair {
  std::int32_t first = 0;
  std::int32_t second = 0;
  friend bool operator==(const PartPair&, const PartPair&) = default;
};

// An object attached to a body: its parts have their own frame, which is fixed to a frame of the
// body.
struct AttachedObject {
  WorldObjectPtr object;
  int link = 0;  // the frame F of the body that it is fixed to
  Pose X_FO = Pose::Identity();
};

// The body of a query: parts fixed in frames of the body, prepared once for the whole batch. A
// rigid body has one frame, B, a robot one frame per link.
struct QueryBody {
  std::shared_ptr<const PreparedModel> geometry;
  std::vector<int> frame_of_part = {};  // empty: all parts are in one frame
  int frame_count = 1;                  // number of frames that BodyRows places
  // The k-th attached object has the frame frame_count + k; its parts follow those of the body.
  std::vector<AttachedObject> attached = {};
  std::vector<PartPair> self_pairs = {};  // pairs of the body's own parts to be tested
  bool tests_world = true;                // false: only self pairs are tested
  // By frame, attached objects included: true if its parts are only tested in self pairs. Empty:
  // the parts of all frames are tested against the world.
  std::vector<bool> self_only_frames = {};
  // Name of the querying object or robot of the world. It is left out of the world, and pair rules
  // refer to it by this name. If empty, only rules for everything apply.
  std::string self = {};
  double margin_m = 0;  // margin of the object `self`
  // Extra margins against the world by own frame, as of padded links; empty: none. Self pairs and
  // attached objects have none.
  std::vector<double> frame_padding_m = {};
  std::string supported_by = {};                           // support of the object `self`
  std::shared_ptr<const Attachment> attachment = nullptr;  // attachment of the object `self`
  std::shared_ptr<const RobotModel> robot = nullptr;       // the robot whose links are the frames
  // How far the body may extend beyond its parts where no sensor saw it (HiddenDepth_m): the
  // answers are kBounded, their bounds larger by this.
  double hidden_m = 0;
  // No answer gets a better label. DEGRADED for a body that only approximates another one.
  Accuracy best_accuracy = Accuracy::kExact;
  // The first parts that only contain those of the body that they stand for: if they keep clear, so
  // does the body, but their contact proves nothing. Its own other parts are then tested in self
  // pairs only.
  std::int32_t containing_count = 0;
  // Spheres by frame that together contain the parts (an open mesh with its whole box). With them
  // CheckCollisions proves pairs apart for many states at once; the results are the same without.
  std::shared_ptr<const SphereModel> bounding_spheres = {};
  std::shared_ptr<ProgramCache> programs = {};  // cache of `robot`; nullptr: each query compiles

  int FrameOf(std::int32_t part) const {
    return frame_of_part.empty() ? 0 : frame_of_part[static_cast<std::size_t>(part)];
  }
  double PaddingOf_m(int frame) const {
    const bool is_own = frame < frame_count && !frame_padding_m.empty();
    return is_own ? frame_padding_m[static_cast<std::size_t>(frame)] : 0;
  }
  double MaxPadding_m() const {
    return frame_padding_m.empty() ? 0 : std::ranges::max(frame_padding_m);
  }
  bool IsContaining(std::int32_t part) const { return part >= 0 && part < containing_count; }
  // True if an own part is only tested in self pairs, whatever its frame.
  bool IsSelfOnly(std::int32_t part) const {
    return containing_count > 0 && !IsContaining(part) && FrameOf(part) < frame_count;
  }
  int TotalFrames() const { return frame_count + static_cast<int>(attached.size()); }
  // The object attached in a frame; nullptr for a frame of the body itself.
  const AttachedObject* AttachedIn(int frame) const {
    return frame < frame_count ? nullptr : &attached[static_cast<std::size_t>(frame - frame_count)];
  }
  // False if the parts in the frame are only tested in self pairs.
  bool TestsWorld(int frame) const {
    const auto k = static_cast<std::size_t>(frame);
    return tests_world && (self_only_frames.empty() || !self_only_frames[k]);
  }
  // True for the name of the body itself and of an object attached to it.
  bool IsNamed(std::string_view name) const {
    const auto is_attached = [&](const AttachedObject& each) { return each.object->name == name; };
    return (!self.empty() && self == name) || std::ranges::any_of(attached, is_attached);
  }
  // True if the parts in the frame belong to a world object, either querying or attached.
  bool IsObjectFrame(int frame) const {
    return AttachedIn(frame) != nullptr || (robot == nullptr && !self.empty());
  }
};
// The body of the given shapes. Its geometry is nullptr if `work` ended the preparation.
QueryBody BodyFromShapes(std::vector<Placed<>> shapes, WorkCounter* work = nullptr);
QueryBody BodyFromObject(const WorldObject& object);

// The poses of a body's frames, row by row. Thread safe.
class BodyRows {
 public:
  virtual ~BodyRows() = default;
  virtual std::size_t size() const = 0;
  // Sets X_WF, one pose for each frame of the body except those of attached objects.
  virtual void Place(std::size_t row, std::span<Pose> X_WF) const = 0;
  // The same for several rows, up to the last bits; `X_WF` holds the poses of one row after the
  // other. The poses of a row depend on that row alone.
  virtual void PlaceRows(std::span<const std::size_t> rows, std::span<Pose> X_WF) const {
    const std::size_t frames = rows.empty() ? 0 : X_WF.size() / rows.size();
    for (std::size_t k = 0; k < rows.size(); ++k) Place(rows[k], X_WF.subspan(k * frames, frames));
  }
  // True if the body can be in the state of the row; otherwise its verdict is OUT_OF_LIMITS.
  // Distances and contacts are computed anyway, but are meaningless for a robot whose links lie
  // outside the largest coordinates of a world (JointRows::RangeFault).
  virtual bool IsWithinLimits(std::size_t) const { return true; }
  // The first variable of a robot that is out of its limits, if one is.
  virtual std::optional<int> VariableOutOfLimits(std::size_t) const { return std::nullopt; }
};

// The rows of a rigid body. Refers to the poses, which must outlive it.
class PoseRows : public BodyRows {
 public:
  explicit PoseRows(std::span<const Pose> X_WB) : X_WB_(X_WB) {}
  std::size_t size() const override { return X_WB_.size(); }
  void Place(std::size_t row, std::span<Pose> X_WF) const override { X_WF[0] = X_WB_[row]; }

 private:
  std::span<const Pose> X_WB_;
};

// The pairs that GetDistances returns for each row.
enum class DistancePairs {
  // The nearest objects, each by its nearest pair of parts. The self pairs count as one object.
  kObjects,
  // For each frame of the body: each object, each link of other robots, and each frame that it is
  // tested against, by the nearest pair of parts. A self pair belongs to the frame of its lower
  // part, which is the part of the body. Ordered by frame, then by distance.
  kLinks
};

enum class EngineChoice { kAuto, kExact, kFcl, kBullet };
std::string_view NameOf(EngineChoice choice);  // as in the API, e.g. "FCL"
// The parts of world objects that are tested, including those of querying and attached objects.
// HYBRID is all of them: shapes, surfaces and handles. Shapes sent with the query and robots are
// always tested with all parts.
enum class Representation { kHybrid, kShapes, kSurfaces };

// Selects whether CheckCollisions names a pair for each row in collision, or only for rows that
// were tested pair by pair, which is many times faster for a robot made of spheres.
enum class Naming { kEachRow, kWhereTested };

// The treatment of objects of kind kUnseen, that is space that no sensor has seen.
enum class UnseenSpace {
  kBlock,   // obstacles like any other
  kIgnore,  // left out
  // A row that collides with nothing else is undecided. Distances, contacts, rays and points report
  // unseen space like any other object, by name.
  kReport
};

// chosen: scans place an object up to a few millimetres below or above its table's surface.
inline constexpr double kSupportTolerance_m = 0.005;

struct QueryOptions {
  EngineChoice engine = EngineChoice::kAuto;
  Representation representation = Representation::kHybrid;
  double margin_m = 0;
  // Objects farther than this are not reported by GetDistances and SamplePoints.
  double max_distance_m = std::numeric_limits<double>::infinity();
  DistancePairs pairs = DistancePairs::kObjects;  // of GetDistances
  // Answers per row of GetDistances, with kLinks per frame; 0, with kLinks: all that are within
  // max_distance_m.
  int max_results = 1;
  // The most answers of all rows of GetDistances; more are OutOfRange.
  std::size_t max_answers = std::numeric_limits<std::size_t>::max();
  // GetDistances also returns the derivatives by the joints, for JointRows.
  bool joint_gradients = false;
  int max_contacts = 16;                     // points per row of GetContacts
  int max_contacts_per_pair = 0;             // points per pair of parts; 0: all
  Naming naming = Naming::kEachRow;          // for CheckCollisions
  std::vector<std::string> ignore = {};      // names of objects and robots that are left out
  std::vector<NamedPair> ignore_pairs = {};  // allowed to collide, besides those of the world
  // Members to which the query is restricted; empty: all. Names in the world restrict the
  // obstacles; RestrictBody restricts the body.
  std::vector<NamedThing> only = {};
  // >= 0: number of standard deviations of each part's surface that are added to the margin.
  double margin_sigma = 0;
  UnseenSpace unseen = UnseenSpace::kBlock;
  // >= 0: depth to which a querying or attached object may reach into its support, if no rule sets
  // the margin of the two.
  double support_tolerance_m = kSupportTolerance_m;
  // Number of threads for a large batch, including the caller's. Each takes chunks of rows; the
  // result has the same bytes for any number.
  int threads = 1;
  // Deadline for handing over the completed prefix. Work stops earlier by the time of the handover.
  std::optional<std::chrono::steady_clock::time_point> deadline = {};
  std::chrono::nanoseconds handover_per_entry{0};  // handover time of one entry of the columns
};

enum class Verdict : std::uint8_t { kNotComputed, kFree, kCollision, kOutOfLimits, kUndecided };

// Value in a column of objects for the body itself, whose other part is `object_part`.
inline constexpr std::int32_t kSelfObject = -2;

// One verdict per row, and for a row in collision or undecided a pair that caused it. A row is
// undecided if no pair certainly collides and the error interval of some pair's distance contains
// its margin. With AUTO and EXACT only depths have an error interval, so that only contact with a
// support or with unseen space to be reported can be undecided.
struct CollisionColumns {
  std::vector<Verdict> verdict;
  std::vector<std::int32_t> object;  // WorldSnapshot::ObstacleAt, kSelfObject; -1: no pair is named
  std::vector<std::int32_t> body_part;  // into the body's parts
  std::vector<std::int32_t> object_part;
  // Accuracy of the named pair; for a free row the weakest of all tested pairs; kDegraded without
  // meaning for a row that was not computed.
  std::vector<Accuracy> accuracy;
  // BodyRows::VariableOutOfLimits for rows that are kOutOfLimits, else -1. Empty if there is no
  // such row, or if Naming is not kEachRow.
  std::vector<std::int32_t> variable = {};
  std::size_t completed = 0;  // rows answered
};

// The pairs of row i are entries [row_begin[i], row_begin[i + 1]).
struct PairColumns {
  std::vector<std::uint32_t> row_begin;  // completed + 1 entries
  std::vector<double> distance_m;
  std::vector<double> point_body;    // x y z, on the query body, world frame
  std::vector<double> point_object;  // x y z, on the world object
  std::vector<double> normal;        // x y z, unit, from the body to the object
  std::vector<std::int32_t> object;  // WorldSnapshot::ObstacleAt, or kSelfObject
  std::vector<std::int32_t> body_part;
  std::vector<std::int32_t> object_part;
  std::vector<Accuracy> accuracy;
  std::vector<double> bound_m;
  // With QueryOptions::joint_gradients: answers x variables of the group, see joint_gradients.h.
  std::vector<double> joint_gradient = {};
  // Likewise: 1 if the distance may have a kink, so that the gradient is one of several. Found are
  // a second pair of parts that the answer stands for, and further contact points of the two parts,
  // that are as near within kTieTolerance_m; not found are several ways out of an overlap that are
  // equally short.
  std::vector<std::uint8_t> gradient_kink = {};
  std::size_t completed = 0;
};

struct RayColumns {
  std::vector<std::uint8_t> hit;  // 0 or 1 per row; the other columns hold zeros if 0
  std::vector<double> distance_m;
  std::vector<double> normal;  // x y z, outward
  std::vector<std::int32_t> object;
  std::vector<std::int32_t> object_part;
  // kBounded if something unseen may lie before the hit, or in the way of a ray that hits nothing.
  std::vector<Accuracy> accuracy;
  std::size_t completed = 0;
};

enum class SampleState : std::uint8_t {
  kSmooth,  // the distance has a gradient
  // Two surface points are equally near, within kKinkTolerance_m (kernels/kink.h), with different
  // gradients: between two objects or two faces, on an axis, at an edge, on an open surface. The
  // gradient is that of one of them.
  kKink,
  kBeyond,  // no object within max_distance_m: the other columns hold zeros
};

// One entry per point.
struct PointColumns {
  std::vector<SampleState> state;
  std::vector<double> distance_m;
  std::vector<double> gradient;  // x y z, unit, world frame
  std::vector<std::int32_t> object;
  std::vector<std::int32_t> object_part;
  std::vector<Accuracy> accuracy;
  // How much less the distance may be, for the rows that are kBounded, ordered by row.
  struct Bound {
    std::uint32_t row;
    double bound_m;
    friend bool operator==(const Bound&, const Bound&) = default;
  };
  std::vector<Bound> bounds;
  std::size_t completed = 0;
};

// CheckCollisions, GetDistances and GetContacts poll `stop` every few rows; a stopped call returns
// Cancelled. They return Unimplemented if the chosen engine does not support a pair that comes up:
// the message names row, engine, object, part and the two kinds. kAuto and kExact support every
// pair. Two half-spaces overlap unless they face each other across a gap; if they overlap without
// limit the distance is -kMaxCoordinate_m, kDegraded.
absl::StatusOr<CollisionColumns> CheckCollisions(const WorldSnapshot& world, const QueryBody& body,
                                                 const BodyRows& rows, const QueryOptions& options,
                                                 std::stop_token stop = {});
// The distances of the pairs that QueryOptions::pairs chooses. InvalidArgument for joint gradients
// of rows that are not JointRows.
absl::StatusOr<PairColumns> GetDistances(const WorldSnapshot& world, const QueryBody& body,
                                         const BodyRows& rows, const QueryOptions& options,
                                         std::stop_token stop = {});
// Contacts are points of pairs with distance below the margin, deepest first within a row. With the
// exact kernels, a pair whose faces or edges meet has up to kMaxPatchPoints contacts besides its
// deepest (kernels/contact_patch.h); with other engines it has only the deepest. If a row has more
// than max_contacts, the deepest points of all pairs take precedence over further points.
absl::StatusOr<PairColumns> GetContacts(const WorldSnapshot& world, const QueryBody& body,
                                        const BodyRows& rows, const QueryOptions& options,
                                        std::stop_token stop = {});

// The same queries for a rigid body at many poses.
inline absl::StatusOr<CollisionColumns> CheckCollisions(const WorldSnapshot& world,
                                                        const QueryBody& body,
                                                        std::span<const Pose> X_WB,
                                                        const QueryOptions& options,
                                                        std::stop_token stop = {}) {
  return CheckCollisions(world, body, PoseRows(X_WB), options, std::move(stop));
}
inline absl::StatusOr<PairColumns> GetDistances(const WorldSnapshot& world, const QueryBody& body,
                                                std::span<const Pose> X_WB,
                                                const QueryOptions& options,
                                                std::stop_token stop = {}) {
  return GetDistances(world, body, PoseRows(X_WB), options, std::move(stop));
}
inline absl::StatusOr<PairColumns> GetContacts(const WorldSnapshot& world, const QueryBody& body,
                                               std::span<const Pose> X_WB,
                                               const QueryOptions& options,
                                               std::stop_token stop = {}) {
  return GetContacts(world, body, PoseRows(X_WB), options, std::move(stop));
}

// The first hit of each ray, by the exact kernels. Unimplemented if another engine is chosen by
// name.
struct RayRow {
  Vector3 origin;
  Vector3 direction;  // unit
  double max_distance_m = std::numeric_limits<double>::infinity();
};
absl::StatusOr<RayColumns> CastRays(const WorldSnapshot& world, std::span<const RayRow> rays,
                                    const QueryOptions& options, std::stop_token stop = {});

// The signed distance and its gradient at points in the world frame, without margins. The distance
// is the least over all parts, so inside a solid it is that of the part in which the point is
// deepest. If other solids cover the way out of that part, the point is deeper in their union:
// kBounded, or kDegraded if no way out is found. The same holds if shells of one closed mesh
// overlap and the nearest triangle lies inside their union. An open mesh has no inside:
// kSurfaceOnly. Closed meshes and hulls are exact over their triangles, vessels over their profile.
//
// Computed by the exact kernels, like CastRays. Coordinates must be finite. The result for a point
// depends only on the point and the world, bit for bit.
absl::StatusOr<PointColumns> SamplePoints(const WorldSnapshot& world,
                                          std::span<const Vector3> points,
                                          const QueryOptions& options, std::stop_token stop = {});

}  // namespace cwm::collision
