#include "server/wire/request_cost.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "absl/strings/str_format.h"
#include "collision/inverse_kinematics/pose_solver.h"
#include "collision/query/query.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

// In seconds. derived: from measured rows and pairs (a state of an arm takes 10 to 40 us, a
// distance three times that) and from 0.95 s for preparing 499,000 triangles; right within a factor
// of three for those.
constexpr double kRequestCost_s = 50e-6;
constexpr double kChangeCost_s = 3e-6;
constexpr double kPartCost_s = 2e-6;         // reading and preparing a primitive or a known mesh
constexpr double kPlateVertexCost_s = 1e-6;  // triangulation
constexpr double kPreparedTriangleCost_s = 3e-6;  // checking watertightness, building its tree
constexpr double kHullVertexCost_s = 3e-6;
constexpr double kRowCost_s = 0.5e-6;
constexpr double kPlacingCost_s = 0.05e-6;   // per part and row
constexpr double kNearPartCost_s = 0.02e-6;  // per pair of nearby parts of weight 1
constexpr double kRayCost_s = 0.3e-6;
constexpr double kByteCost_s = 5e-9;

// The cost of an answer relative to a verdict. A motion costs a few dozen states.
constexpr double kDistanceFactor = 4, kLinkDistancesFactor = 20, kContactsFactor = 6,
                 kMotionFactor = 30, kPointFactor = 1;

// chosen: shapes beyond this number are not examined but assumed to cost the same as those before.
constexpr int kMaxExaminedShapes = 2'048;

// Sums up the cost of the shapes in a request.
class ShapeCosts {
 public:
  explicit ShapeCosts(const GeometryStore& store) : store_(store) {}

  // `M` is any message with the oneof `shape`.
  template <class M>
  void Add(const M& m) {
    if (shape_count_++ >= kMaxExaminedShapes) return;
    cost_s_ += kPartCost_s;
    weight_ += 1;
    switch (m.shape_case()) {
      case M::kPlate:
        AddPlate(m.plate());
        break;
      case M::kConvex:
        AddStored(m.convex().hash(), true);
        break;
      case M::kMesh:
        AddStored(m.mesh().hash(), false);
        break;
      default:
        break;
    }
  }
  void AddSurface(const std::string& hash) {
    if (shape_count_++ >= kMaxExaminedShapes) return;
    cost_s_ += kPartCost_s;
    AddStored(hash, false);
  }

  double cost_s() const { return cost_s_ * Scale(); }
  double weight() const { return weight_ * Scale(); }

 private:
  double Scale() const {
    return shape_count_ <= kMaxExaminedShapes ? 1 : 1.0 * shape_count_ / kMaxExaminedShapes;
  }

  void AddPlate(const v1::Plate& plate) {
    int vertices = plate.outline().vertices_size();
    for (const v1::Polygon& hole : plate.holes()) vertices += hole.vertices_size();
    cost_s_ += kPlateVertexCost_s * vertices;
    weight_ += vertices / 64.0;
  }

  // A mesh is prepared once for all who use it, and not again while somebody holds it.
  void AddStored(const std::string& hash, bool is_hull) {
    const auto stored = store_.FindMesh(hash);
    if (!stored.ok() || stored->mesh == nullptr) return;
    const double triangles = static_cast<double>(stored->mesh->triangles.size());
    weight_ += 4 + static_cast<double>(std::bit_width(stored->mesh->triangles.size()));
    const bool is_new =
        stored->facts->computed() == 0 && counted_meshes_.insert(stored->mesh.get()).second;
    if (!is_new) return;
    cost_s_ += is_hull ? kHullVertexCost_s * static_cast<double>(stored->mesh->vertices.size())
                       : kPreparedTriangleCost_s * triangles;
  }

  const GeometryStore& store_;
  std::unordered_set<const TriangleMesh*> counted_meshes_;
  std::int64_t shape_count_ = 0;
  double cost_s_ = 0;
  double weight_ = 0;
};

template <class Changes>
double ChangesCost_s(const Changes& changes, const GeometryStore& store) {
  if (changes.empty()) return 0;
  ShapeCosts shapes(store);
  for (const v1::Change& change : changes) {
    if (!change.has_put()) continue;
    for (const v1::ShapePart& part : change.put().object().shapes()) shapes.Add(part);
    for (const v1::SurfacePart& part : change.put().object().surfaces()) {
      shapes.AddSurface(part.hash());
    }
  }
  return kChangeCost_s * changes.size() + shapes.cost_s();
}

std::size_t RowsOf(v1::Scalar scalar, const std::string& data, std::size_t width) {
  const std::size_t bytes = width * (scalar == v1::SCALAR_F32 ? sizeof(float) : sizeof(double));
  return std::max<std::size_t>(1, data.size() / std::max<std::size_t>(1, bytes));
}

// The subject of a query: its weight, its number of rows, and the time to read it.
struct Body {
  double weight = 1;
  double rows = 1;
  double reading_s = 0;
};

Body BodyOf(const v1::Subject::Shapes& shapes, const CostSource& source) {
  constexpr std::size_t kPoseWidth = 7;
  ShapeCosts read(source.store);
  for (const v1::PlacedShape& shape : shapes.shapes()) read.Add(shape);
  const v1::PoseRows& rows = shapes.x_world_body();
  return {.weight = read.weight(),
          .rows = static_cast<double>(RowsOf(rows.scalar(), rows.data(), kPoseWidth)),
          .reading_s = read.cost_s()};
}

Body BodyOf(const v1::Subject::WorldObject& subject, const CostSource& source) {
  constexpr std::size_t kPoseWidth = 7;
  const v1::PoseRows& rows = subject.x_world_object();
  Body body{.rows = static_cast<double>(RowsOf(rows.scalar(), rows.data(), kPoseWidth))};
  if (source.snapshot == nullptr) return body;
  const auto* object = source.snapshot->objects().Find(subject.name());
  if (object != nullptr) body.weight = static_cast<double>((*object)->geometry->weight);
  return body;
}

Body BodyOf(const v1::RobotSubject& subject, const CostSource& source) {
  Body body;
  const v1::JointRows& rows = subject.rows();
  if (source.snapshot == nullptr) return body;
  const collision::WorldRobotPtr robot = source.snapshot->FindRobot(subject.robot());
  if (robot == nullptr) return body;
  const collision::RobotModel& model = robot->model();
  const collision::JointGroup* const group =
      subject.group().empty() ? &model.all : model.FindGroup(subject.group());
  const std::size_t width = group != nullptr ? group->variables.size() : 1;
  body.rows = static_cast<double>(RowsOf(rows.scalar(), rows.data(), width));
  body.weight = static_cast<double>(robot->robot->geometry->weight);
  for (const collision::WorldObjectPtr& attached : source.snapshot->attached()) {
    if (attached->attachment->robot == subject.robot()) {
      body.weight += static_cast<double>(attached->geometry->weight);
    }
  }
  return body;
}

Body BodyOf(const v1::Subject& subject, const CostSource& source) {
  constexpr std::size_t kPointWidth = 3;
  switch (subject.what_case()) {
    case v1::Subject::kShapes:
      return BodyOf(subject.shapes(), source);
    case v1::Subject::kObject:
      return BodyOf(subject.object(), source);
    case v1::Subject::kRobot:
      return BodyOf(subject.robot(), source);
    case v1::Subject::kPoints: {
      const v1::Subject::Points& points = subject.points();
      return {.rows = static_cast<double>(RowsOf(points.scalar(), points.data(), kPointWidth))};
    }
    case v1::Subject::WHAT_NOT_SET:
      break;
  }
  return {};
}

// The weight of world parts that one part of a body is tested against: the nodes on a path through
// a tree of boxes, and a nearby object or robot of mean weight.
double NearWeight(const CostSource& source) {
  if (source.snapshot == nullptr) return 1;
  const std::size_t count = source.snapshot->objects().size() + source.snapshot->robots().size();
  if (count == 0) return 0;
  const double mean = static_cast<double>(source.snapshot->weight()) / static_cast<double>(count);
  return std::bit_width(count) + mean;
}

// The cost of a query about a body whose answer costs `factor` times a verdict.
template <class Request>
double BodyCost_s(const Request& request, const CostSource& source, double factor) {
  const Body body = BodyOf(request.subject(), source);
  const double part_cost_s = kPlacingCost_s + kNearPartCost_s * factor * NearWeight(source);
  return kRequestCost_s + kByteCost_s * static_cast<double>(request.options().ignore_size()) +
         ChangesCost_s(request.options().overlay(), source.store) + body.reading_s +
         body.rows * (kRowCost_s * factor + body.weight * part_cost_s);
}

}  // namespace

double EstimatedCost_s(const v1::CheckCollisionsRequest& request, const CostSource& source) {
  return BodyCost_s(request, source, 1);
}

double EstimatedCost_s(const v1::GetDistancesRequest& request, const CostSource& source) {
  const bool by_link = request.pairs() == v1::DISTANCE_PAIRS_LINKS;
  return BodyCost_s(request, source, by_link ? kLinkDistancesFactor : kDistanceFactor);
}

double EstimatedCost_s(const v1::GetContactsRequest& request, const CostSource& source) {
  return BodyCost_s(request, source, kContactsFactor);
}

double EstimatedCost_s(const v1::GetWorldContactsRequest& request, const CostSource& source) {
  // measured: a box with four neighbours that it touches takes 6 us.
  constexpr double kTouchingPartCost_s = 6e-6;
  const double changes_s = ChangesCost_s(request.options().overlay(), source.store);
  if (source.snapshot == nullptr) return kRequestCost_s + changes_s;
  return kRequestCost_s + changes_s +
         kTouchingPartCost_s * static_cast<double>(source.snapshot->weight());
}

double EstimatedCost_s(const v1::CheckMotionsRequest& request, const CostSource& source) {
  return BodyCost_s(request, source, kMotionFactor);
}

double EstimatedCost_s(const v1::SolvePosesRequest& request, const CostSource& source) {
  // measured: a step from eight starts takes half a microsecond. A pose that is reached takes some
  // ten steps, others all of them; chosen: one in ten is not reached.
  constexpr double kStepCost_s = 5e-7, kUnreached = 0.1;
  constexpr int kDefaultSteps = collision::kIkSteps, kTypicalSteps = 10;
  constexpr std::size_t kPoseWidth = 7;
  const double poses = static_cast<double>(
      RowsOf(request.x_world_tool().scalar(), request.x_world_tool().data(), kPoseWidth));
  const int most = request.max_steps() > 0 ? request.max_steps() : kDefaultSteps;
  const double solutions = std::max(1, request.max_solutions());
  const double search_s = kStepCost_s * (kTypicalSteps * solutions + kUnreached * most);
  const Body body = BodyOf(request.robot(), source);
  const double verdicts = request.avoid_collision() ? 4 * solutions : 0;
  const double part_cost_s = kPlacingCost_s + kNearPartCost_s * NearWeight(source);
  return kRequestCost_s + ChangesCost_s(request.options().overlay(), source.store) +
         body.reading_s + poses * (kRowCost_s + search_s + verdicts * body.weight * part_cost_s);
}

double EstimatedCost_s(const v1::GetLinkPosesRequest& request, const CostSource& source) {
  const Body body = BodyOf(request.robot(), source);
  return kRequestCost_s + ChangesCost_s(request.options().overlay(), source.store) +
         body.reading_s + body.rows * (kRowCost_s + body.weight * kPlacingCost_s);
}

double EstimatedCost_s(const v1::CastRaysRequest& request, const CostSource& source) {
  constexpr std::size_t kRayWidth = 6;
  const double rows =
      static_cast<double>(RowsOf(request.rays().scalar(), request.rays().data(), kRayWidth));
  return kRequestCost_s + ChangesCost_s(request.options().overlay(), source.store) +
         rows * (kRowCost_s + kRayCost_s * NearWeight(source));
}

double EstimatedCost_s(const v1::SamplePointsRequest& request, const CostSource& source) {
  constexpr std::size_t kPointWidth = 3;
  const double rows =
      static_cast<double>(RowsOf(request.points().scalar(), request.points().data(), kPointWidth));
  return kRequestCost_s + ChangesCost_s(request.options().overlay(), source.store) +
         rows * (kRowCost_s + kNearPartCost_s * kPointFactor * NearWeight(source));
}

double EstimatedCost_s(const v1::StreamQueriesRequest& request, const CostSource& source) {
  const double overlay_s =
      request.has_overlay() ? ChangesCost_s(request.overlay().changes(), source.store) : 0;
  switch (request.query_case()) {
    case v1::StreamQueriesRequest::kCheckCollisions:
      return overlay_s + EstimatedCost_s(request.check_collisions(), source);
    case v1::StreamQueriesRequest::kGetDistances:
      return overlay_s + EstimatedCost_s(request.get_distances(), source);
    case v1::StreamQueriesRequest::kGetContacts:
      return overlay_s + EstimatedCost_s(request.get_contacts(), source);
    case v1::StreamQueriesRequest::kGetWorldContacts:
      return overlay_s + EstimatedCost_s(request.get_world_contacts(), source);
    case v1::StreamQueriesRequest::kCastRays:
      return overlay_s + EstimatedCost_s(request.cast_rays(), source);
    case v1::StreamQueriesRequest::kSamplePoints:
      return overlay_s + EstimatedCost_s(request.sample_points(), source);
    case v1::StreamQueriesRequest::kCheckMotions:
      return overlay_s + EstimatedCost_s(request.check_motions(), source);
    case v1::StreamQueriesRequest::kSolvePoses:
      return overlay_s + EstimatedCost_s(request.solve_poses(), source);
    case v1::StreamQueriesRequest::QUERY_NOT_SET:
      break;
  }
  return kRequestCost_s + overlay_s;
}

double EstimatedCost_s(const v1::ApplyChangesRequest& request, const CostSource& source) {
  return kRequestCost_s + ChangesCost_s(request.changes(), source.store);
}

double GeometryCost_s(std::int64_t bytes) {
  return kRequestCost_s + kByteCost_s * static_cast<double>(bytes);
}

absl::Status CheckCost(double cost_s, const Limits& limits) {
  if (cost_s <= limits.max_request_cost_s) return absl::OkStatus();
  const std::string estimate = absl::StrFormat("%.1f", cost_s);
  const std::string limit = absl::StrFormat("%.1f", limits.max_request_cost_s);
  return MakeError(
      absl::StatusCode::kResourceExhausted,
      absl::StrFormat("the request would take about %s s of one core, must take at most %s s "
                      "(max_request_cost_s): split its rows or changes",
                      estimate, limit),
      {.reason = "REQUEST_TOO_COSTLY",
       .metadata = {{"estimated_cost_s", estimate}, {"max_request_cost_s", limit}}});
}

}  // namespace cwm::server
