// Questions to one snapshot of the world, in batches: a body of shapes at many poses, a robot in many
// states, rays, points. Answers lie in columns. The same snapshot and question give the same bytes
// on any number of threads; ties break by object name, then part.
//
// Margins: distance and depth are geometric, margins never enter them. A state collides when the
// distance of some pair is strictly less than its margin: what a rule of the pair sets, else the
// margin of the object plus the margin of the object that asks or is carried, if one is, plus the
// margin of the request; and in either case margin_sigma deviations of either part's surface.
// Robots and their links have no margins of their own. Between an object that asks or is carried
// and what supports it the margin is less than none, -support_tolerance_m: it stands there.
//
// A robot of the world is an obstacle where its state puts it, but to itself. What is attached to a
// robot that asks is part of its body, and no obstacle to it.
//
// Pairs that may collide, by the SRDF, the world or the request, are seen by no question: they are
// in no verdict, distance or contact. Rays and sampled points are of no body: no rule is about them.
#pragma once

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
#include "collision/kernels/pair_answer.h"
#include "collision/world/world_snapshot.h"

namespace cwm::collision {

class ProgramMemo;  // spheres/program_memo.h

// Two parts of one body.
struct PartPair {
  std::int32_t first = 0;
  std::int32_t second = 0;
  friend bool operator==(const PartPair&, const PartPair&) = default;
};

// An object that a body carries: its parts are in a frame of their own, fixed to one of the body's.
struct CarriedObject {
  WorldObjectPtr object;
  int link = 0;  // the frame of the body, F
  Pose X_FO = Pose::Identity();
};

// What asks: parts fixed in frames of the body, prepared once for the whole batch. A rigid body has
// one frame, B, a robot one for each link.
struct QueryBody {
  std::shared_ptr<const PreparedModel> geometry;
  std::vector<int> frame_of_part = {};  // empty: all in one frame
  int frame_count = 1;                  // of those that rows place
  // The k-th has the frame frame_count + k; its parts come after those of the body.
  std::vector<CarriedObject> carried = {};
  std::vector<PartPair> self_pairs = {};  // that must not collide either
  bool asks_world = true;                 // false: about itself alone
  // Name of the object or robot of the world that asks: it is left out of the world, and rules of
  // pairs know it by that. Empty: only rules of everything are about it.
  std::string self = {};
  double margin_m = 0;                                     // of the world object that asks
  std::string supported_by = {};                           // likewise
  std::shared_ptr<const Attachment> attachment = nullptr;  // likewise
  std::shared_ptr<const RobotModel> robot = nullptr;       // whose links are the frames
  // No answer is labelled better: of a body that merely stands for another, DEGRADED.
  Trust best_trust = Trust::kExact;
  // By frame: spheres that together contain the parts, of an open mesh its whole box. With them
  // CheckCollisions proves pairs apart for many states at once: what is told is the same without.
  std::shared_ptr<const SphereModel> around = {};
  std::shared_ptr<ProgramMemo> programs = {};  // of `robot`; nullptr: each question compiles

  int FrameOf(std::int32_t part) const {
    return frame_of_part.empty() ? 0 : frame_of_part[static_cast<std::size_t>(part)];
  }
  int AllFrames() const { return frame_count + static_cast<int>(carried.size()); }
  // Of a frame what is carried in it; nullptr: one of the body itself.
  const CarriedObject* CarriedIn(int frame) const {
    return frame < frame_count ? nullptr : &carried[static_cast<std::size_t>(frame - frame_count)];
  }
  // Whether what is in the frame is of an object of the world, which asks or is carried.
  bool IsOfObject(int frame) const {
    return CarriedIn(frame) != nullptr || (robot == nullptr && !self.empty());
  }
};
// Its geometry is null where `work` ended it.
QueryBody BodyFromShapes(std::vector<Placed<>> shapes, WorkCounter* work = nullptr);
QueryBody BodyFromObject(const WorldObject& object);

// Where the frames of a body are, row by row. Thread safe.
class BodyRows {
 public:
  virtual ~BodyRows() = default;
  virtual std::size_t size() const = 0;
  // Sets X_WF, one pose for each frame of the body but those of what it carries.
  virtual void Place(std::size_t row, std::span<Pose> X_WF) const = 0;
  // The same of several rows but for the last bits, one after the other in `X_WF`, which has as many
  // poses for each. What is told of a row depends on that row alone.
  virtual void PlaceSome(std::span<const std::size_t> rows, std::span<Pose> X_WF) const {
    const std::size_t frames = rows.empty() ? 0 : X_WF.size() / rows.size();
    for (std::size_t k = 0; k < rows.size(); ++k) Place(rows[k], X_WF.subspan(k * frames, frames));
  }
  // Whether the row is a state that the body can be in: else its verdict is OUT_OF_LIMITS. Distances
  // and contacts are told all the same: of a robot whose links are where worlds have no room
  // (JointRows::RangeFault) they are worth nothing.
  virtual bool IsWithinLimits(std::size_t) const { return true; }
  // Of a robot that is not, the first of its variables that is out of its limits.
  virtual std::optional<int> VariableOutOfLimits(std::size_t) const { return std::nullopt; }
};

// Of a rigid body. Refers to poses that somebody else keeps.
class PoseRows : public BodyRows {
 public:
  explicit PoseRows(std::span<const Pose> X_WB) : X_WB_(X_WB) {}
  std::size_t size() const override { return X_WB_.size(); }
  void Place(std::size_t row, std::span<Pose> X_WF) const override { X_WF[0] = X_WB_[row]; }

 private:
  std::span<const Pose> X_WB_;
};

enum class EngineChoice { kAuto, kExact, kFcl, kBullet };
std::string_view NameOf(EngineChoice choice);  // as in the API, e.g. "FCL"
// Which parts of world objects count, of the one that asks and of those that are carried as well:
// HYBRID is shapes and surfaces and handles. Shapes that ask and robots are asked whole.
enum class Representation { kHybrid, kShapes, kSurfaces };

// Whether CheckCollisions names a pair for each row in collision, or for those alone that it asked
// about pair by pair: a robot of spheres is then many times faster.
enum class Naming { kEachRow, kWhereAsked };

// What objects of kind kUnseen, space that no sensor has seen, count as.
enum class UnseenSpace {
  kBlock,   // obstacles like any other
  kIgnore,  // nothing
  // Doubt: what collides with nothing else is undecided. Distances, contacts, rays and points tell
  // of it like of any other, by name.
  kReport
};

// Scans place an object a few millimetres into its table or above it.
inline constexpr double kSupportTolerance_m = 0.005;

struct QueryOptions {
  EngineChoice engine = EngineChoice::kAuto;
  Representation representation = Representation::kHybrid;
  double margin_m = 0;
  // Objects farther than this are not reported by GetDistances and SamplePoints.
  double max_distance_m = std::numeric_limits<double>::infinity();
  int max_results = 1;                       // nearest objects per row of GetDistances
  int max_contacts = 16;                     // points per row of GetContacts
  Naming naming = Naming::kEachRow;          // of CheckCollisions
  std::vector<std::string> ignore = {};      // names of objects and robots that are left out
  std::vector<NamedPair> ignore_pairs = {};  // that may collide, besides those of the world
  // >= 0: so many deviations of its surface are part of each part's margin.
  double margin_sigma = 0;
  UnseenSpace unseen = UnseenSpace::kBlock;
  // >= 0: how deep an object that asks or is carried may reach into what supports it, where no rule
  // sets the margin of the two.
  double support_tolerance_m = kSupportTolerance_m;
  // For a large batch, the caller's included: each takes chunks of rows. The answer has the same
  // bytes on any number.
  int threads = 1;
  // The completed prefix is handed over by then: work stops earlier by as much as that takes.
  std::optional<std::chrono::steady_clock::time_point> give_up_at = {};
  std::chrono::nanoseconds handover_of_answer{0};  // of one entry of the columns
};

enum class Verdict : std::uint8_t { kNotComputed, kFree, kCollision, kOutOfLimits, kUndecided };

// In a column of objects: the body itself, whose other part is `object_part`.
inline constexpr std::int32_t kItself = -2;

// One byte a row; for a row in collision or undecided a pair that told. A row is undecided when no
// pair surely collides and of some pair the distance and its bound straddle the margin. AUTO and EXACT
// bound depths alone: with them only what may reach into its support, or meets unseen space that is
// to be reported, is undecided.
struct CollisionColumns {
  std::vector<Verdict> verdict;
  std::vector<std::int32_t> object;     // WorldSnapshot::ObstacleAt, kItself; -1: no pair is named
  std::vector<std::int32_t> body_part;  // into the body's parts
  std::vector<std::int32_t> object_part;
  // Of the pair named; of a free row, the weakest of the pairs asked; of one that is not computed of
  // no meaning, kDegraded.
  std::vector<Trust> trust;
  // Of the robot that asks: of a row that is kOutOfLimits, BodyRows::VariableOutOfLimits, else -1.
  // Empty where no row is, or not each row is to be named.
  std::vector<std::int32_t> variable = {};
  std::size_t completed = 0;  // rows answered
};

// Answers of row i lie at [row_begin[i], row_begin[i + 1]).
struct PairColumns {
  std::vector<std::uint32_t> row_begin;  // completed + 1 entries
  std::vector<double> distance_m;
  std::vector<double> point_body;    // x y z, on the query body, world frame
  std::vector<double> point_object;  // x y z, on the world object
  std::vector<double> normal;        // x y z, unit, from the body to the object
  std::vector<std::int32_t> object;  // WorldSnapshot::ObstacleAt, or kItself
  std::vector<std::int32_t> body_part;
  std::vector<std::int32_t> object_part;
  std::vector<Trust> trust;
  std::vector<double> bound_m;
  std::size_t completed = 0;
};

struct RayColumns {
  std::vector<std::uint8_t> hit;  // 0 or 1 a row; the other columns hold zeros where 0
  std::vector<double> distance_m;
  std::vector<double> normal;  // x y z, outward
  std::vector<std::int32_t> object;
  std::vector<std::int32_t> object_part;
  std::size_t completed = 0;
};

enum class SampleState : std::uint8_t {
  kSmooth,  // the gradient is that of the distance
  // Two nearest places within kKinkReach_m (kernels/kink.h) pull different ways: of two objects, of
  // two faces in a solid, on its axis, at its edge, on an open surface. The gradient is one of theirs.
  kKink,
  kBeyond,  // no object within max_distance_m: the other columns hold zeros
};

// One entry a point.
struct PointColumns {
  std::vector<SampleState> state;
  std::vector<double> distance_m;
  std::vector<double> gradient;  // x y z, unit, world frame
  std::vector<std::int32_t> object;
  std::vector<std::int32_t> object_part;
  std::vector<Trust> trust;
  // Of rows that are kBounded, by row: by how much the point may be deeper.
  struct Bound {
    std::uint32_t row;
    double bound_m;
    friend bool operator==(const Bound&, const Bound&) = default;
  };
  std::vector<Bound> bounds;
  std::size_t completed = 0;
};

// The three poll `stop` every few rows; a stopped call returns Cancelled. Unimplemented when the
// chosen engine cannot answer a pair that comes up: the message names row, engine, object, part and
// the two kinds. kAuto and kExact answer every pair. Two half-spaces overlap unless they face each other
// across a gap; where they overlap without end the distance is -kLargestCoordinate_m, kDegraded.
absl::StatusOr<CollisionColumns> CheckCollisions(const WorldSnapshot& world, const QueryBody& body,
                                                 const BodyRows& rows, const QueryOptions& options,
                                                 std::stop_token stop = {});
// Of a body with self pairs, itself counts like one more object: by its nearest pair.
absl::StatusOr<PairColumns> GetDistances(const WorldSnapshot& world, const QueryBody& body,
                                         const BodyRows& rows, const QueryOptions& options,
                                         std::stop_token stop = {});
// Contacts are points of pairs with distance below the margin, deepest first within a row. By the
// exact kernels a pair whose faces or edges meet has up to kMostPatchPoints besides its deepest
// (kernels/contact_patch.h); by other engines there is the deepest alone. Where a row
// has more than max_contacts, the deepest points of pairs come before further ones of any pair.
absl::StatusOr<PairColumns> GetContacts(const WorldSnapshot& world, const QueryBody& body,
                                        const BodyRows& rows, const QueryOptions& options,
                                        std::stop_token stop = {});

// The same of a rigid body at poses.
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

// By the exact kernels: Unimplemented when another engine is asked for by name.
struct RayRow {
  Vector3 origin;
  Vector3 direction;  // unit
  double max_distance_m = std::numeric_limits<double>::infinity();
};
absl::StatusOr<RayColumns> CastRays(const WorldSnapshot& world, std::span<const RayRow> rays,
                                    const QueryOptions& options, std::stop_token stop = {});

// The signed distance of the world at points in the world frame, and which way it grows. That of the
// nearest part, without margins; the least of all, so in a solid that of the part in which the point
// is deepest. Where other solids cover the way out of that part the point is deeper in their union:
// kBounded, or kDegraded where no way out is found; so it is where shells of one closed mesh overlap or
// lie within each other, and the nearest triangle is within their union. An open mesh has no inside:
// kSurfaceOnly. Closed meshes and hulls are exact over their triangles, vessels over their profile.
//
// By the exact kernels, as CastRays. Coordinates are finite. The answer of a point depends on it and
// on the world alone, bit for bit.
absl::StatusOr<PointColumns> SamplePoints(const WorldSnapshot& world,
                                          std::span<const Vector3> points,
                                          const QueryOptions& options, std::stop_token stop = {});

}  // namespace cwm::collision
