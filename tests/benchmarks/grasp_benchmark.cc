// Grasps planned on a scan, checked against the true scene.

// The shapes of the truth are those of collision/geometry; the client's are in cwm::api.
#define CWM_QUALIFIED_NAMES

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "clients/cpp/cloud_upload.h"
#include "clients/grasp/plan_grasps.h"
#include "clients/grasp/sample_object.h"
#include "clients/simulator/simulated_files.h"
#include "collision/geometry/signed_distance.h"
#include "perception/simulation/random_scenes.h"
#include "perception/simulation/virtual_scanner.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/running_server.h"

namespace cwm::benchmarks {
namespace {

// Sets the true solid; false for kinds that no table has.
bool SetTrueShape(const Shape& shape, v1::ShapePart* part) {
  if (SetShape(shape, part)) return true;
  const auto set_outline = [&](const Plate& plate) {
    for (const Vector2& corner : plate.outline) {
      v1::Vector2& vertex = *part->mutable_plate()->mutable_outline()->add_vertices();
      vertex.set_x(corner.x());
      vertex.set_y(corner.y());
    }
    part->mutable_plate()->set_thickness_m(plate.thickness_m);
  };
  if (const auto* cone = std::get_if<Cone>(&shape)) {
    part->mutable_cone()->set_radius_bottom_m(cone->radius_bottom_m);
    part->mutable_cone()->set_radius_top_m(cone->radius_top_m);
    part->mutable_cone()->set_length_m(cone->length_m);
  } else if (const auto* plate = std::get_if<Plate>(&shape); plate && plate->holes.empty()) {
    set_outline(*plate);
  } else {
    return false;
  }
  return true;
}

bool PutTrueObjects(const client::Connection& connection, const perception::SimulatedScene& scene,
                    const std::string& world) {
  v1::ApplyChangesRequest request;
  request.set_world(world);
  for (const perception::SimulatedObject& object : scene.objects) {
    v1::Object& put = *request.add_changes()->mutable_put()->mutable_object();
    put.set_name(object.name);
    put.set_kind(object.is_support ? v1::OBJECT_KIND_SUPPORT : v1::OBJECT_KIND_OBJECT);
    SetPose(object.X_WO, put.mutable_x_world_object());
    for (const Placed<>& placed : object.parts) {
      v1::ShapePart* part = put.add_shapes();
      SetPose(placed.X_FS, part->mutable_x_object_shape());
      if (!SetTrueShape(placed.shape, part)) return false;
    }
  }
  return connection.Call(&v1::WorldService::Stub::ApplyChanges, connection.worlds(), request).ok();
}

bool IngestScan(const client::Connection& connection, const perception::SimulatedView& view,
                std::uint64_t seed, const std::string& world) {
  const perception::SimulatedCloud scan = perception::Scan(
      view.scene, view.camera,
      {.noise = {.model = perception::SensorModel::kKinect}, .noiseless = false, .seed = seed});
  v1::IngestCloudHeader header;
  header.set_world(world);
  SetPose(view.camera.X_WC, header.mutable_x_world_sensor());
  return client::IngestCloud(connection, header, simulator::ToCloudFile(scan.cloud)).ok();
}

void DeleteWorld(const client::Connection& connection, const std::string& world) {
  v1::DeleteWorldRequest request;
  request.set_world(world);
  // The worlds are in the benchmark's own server: one that remains only costs memory.
  (void)connection.Call(&v1::WorldService::Stub::DeleteWorld, connection.worlds(), request);
}

struct Count {
  int graspable = 0, confirmed = 0, objects = 0, found_without_truth = 0;
  std::map<std::string, int> failures = {};
  std::vector<std::string> lines = {};  // the failures and where they happened

  void Fail(std::uint64_t seed, const std::string& object, const std::string& what,
            const std::string& detail) {
    ++failures[what];
    lines.push_back("table " + std::to_string(seed) + " " + object + ": " + what + " " + detail);
  }
};

Eigen::Vector3d CentreOf(const perception::SimulatedObject& object) {
  const Aabb bounds = BoundsInWorld(object);
  return bounds.center();
}

// The found object whose bounds have their middle nearest to the true one's, at most 5 cm away;
// null if there is none. Objects stand at least 2 cm apart and are some 4 cm wide.
const grasp::ObjectPlan* PlanFor(const perception::SimulatedObject& object,
                                 const grasp::Plan& plan) {
  constexpr double kSamePlace_m = 0.05;
  const grasp::ObjectPlan* nearest = nullptr;
  double nearest_m = kSamePlace_m;
  for (const grasp::ObjectPlan& found : plan.objects) {
    const Eigen::Isometry3d X_WB = found.object.X_WO * found.object.bounds->X_OB;
    const double distance_m = (X_WB.translation() - CentreOf(object)).norm();
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    nearest = &found;
  }
  return nearest;
}

const char* NameOf(grasp::GraspFailure failure) {
  switch (failure) {
    case grasp::GraspFailure::kNone:
      return "confirmed";
    case grasp::GraspFailure::kBlocked:
      return "hits";
    case grasp::GraspFailure::kMissed:
      return "misses";
    case grasp::GraspFailure::kSlipped:
      return "slips";
  }
  return "?";
}

// Assesses the best grasp of the scan in the true scene. It may come as near as touching.
grasp::Assessment AssessBestGrasp(const api::WorldView& truth, const grasp::PlanRequest& request,
                                  const std::string& object, const grasp::Grasp& best) {
  grasp::GraspQuery query = grasp::MakeGraspQuery(request);
  query.clearance_m = 0;
  return grasp::Assess(truth, query, {{.X_WG = best.candidate.X_FG, .target = object}}).front();
}

// The same assessment with the formulas of the true shapes alone: points 6 mm apart in the open
// gripper at every centimetre of its approach, and positions of the pads moved inwards in steps of
// 0.1 mm.
class PointChecker {
 public:
  PointChecker(const perception::SimulatedScene& scene, const grasp::GraspQuery& query)
      : scene_(scene), query_(query) {}

  bool Confirms(const Eigen::Isometry3d& X_WG, const std::string& object) const {
    return ApproachIsFree(X_WG) && Holds(X_WG, object, -1) && Holds(X_WG, object, 1);
  }

 private:
  struct Nearest {
    const perception::SimulatedObject* object = nullptr;
    double distance_m = std::numeric_limits<double>::infinity();
    Vector3 normal_W = Vector3::Zero();
  };

  Nearest NearestTo(const Vector3& p_W) const {
    Nearest nearest;
    for (const perception::SimulatedObject& object : scene_.objects) {
      for (const Placed<>& placed : object.parts) {
        const Pose X_WS = object.X_WO * placed.X_FS;
        const SurfacePoint at = NearestSurfacePoint(placed.shape, X_WS.inverse() * p_W);
        if (at.signed_distance_m >= nearest.distance_m) continue;
        nearest = {&object, at.signed_distance_m, X_WS.linear() * at.normal};
      }
    }
    return nearest;
  }

  bool ApproachIsFree(const Eigen::Isometry3d& X_WG) const {
    constexpr double kStep_m = 0.01, kGrid_m = 0.006, kRounding_m = 1e-6;
    for (double back_m = 0; back_m <= query_.approach_m; back_m += kStep_m) {
      for (const grasp::GripperBox& box : grasp::OpenBoxes(query_.gripper)) {
        const Eigen::Array3i steps = (box.size_m / kGrid_m).array().ceil().cast<int>();
        for (int i = 0; i <= steps.x(); ++i) {
          for (int j = 0; j <= steps.y(); ++j) {
            for (int k = 0; k <= steps.z(); ++k) {
              const Eigen::Array3d share = Eigen::Array3d(i, j, k) / steps.cast<double>() - 0.5;
              const Vector3 p_G =
                  box.centre_G + (share * box.size_m.array()).matrix() - Vector3(0, 0, back_m);
              if (NearestTo(X_WG * p_G).distance_m < -kRounding_m) return false;
            }
          }
        }
      }
    }
    return true;
  }

  // True if the first object that the pad on this side meets is the grasped one, within friction.
  bool Holds(const Eigen::Isometry3d& X_WG, const std::string& object, double side) const {
    constexpr double kStep_m = 0.0001;
    const grasp::Gripper& gripper = query_.gripper;
    for (double x_m = gripper.opening_m / 2; x_m > -gripper.opening_m / 2; x_m -= kStep_m) {
      for (const double y : {0.0, -0.25, 0.25, -0.5, 0.5}) {
        for (const double z : {0.0, -0.25, 0.25, -0.5, 0.5}) {
          const Vector3 p_W =
              X_WG * Vector3(side * x_m, y * gripper.finger_width_m, z * gripper.pad_length_m);
          const Nearest met = NearestTo(p_W);
          if (met.distance_m > 0) continue;
          const double along = side * met.normal_W.dot(X_WG.linear().col(0));
          return met.object->name == object && along >= std::cos(std::atan(query_.friction));
        }
      }
    }
    return false;
  }

  const perception::SimulatedScene& scene_;
  grasp::GraspQuery query_;
};

bool MeasureTable(const client::Connection& connection, std::uint64_t seed, Count& count) {
  const perception::SimulatedView view =
      perception::RandomScene(perception::SceneFamily::kTable, seed);
  const std::string seen = "seen_" + std::to_string(seed),
                    true_world = "true_" + std::to_string(seed);
  if (!PutTrueObjects(connection, view.scene, true_world)) return false;
  if (!IngestScan(connection, view, seed, seen)) return false;
  const api::Server server({.address = connection.address()});
  const api::World truly = server.GetWorld(true_world);
  const grasp::PlanRequest request;
  const auto truth = grasp::PlanGrasps(truly, request);
  const auto plan = grasp::PlanGrasps(server.GetWorld(seen), request);
  if (!truth.ok() || !plan.ok()) return false;
  for (const perception::SimulatedObject& object : view.scene.objects) {
    const auto admits =
        std::find_if(truth->objects.begin(), truth->objects.end(),
                     [&](const grasp::ObjectPlan& of) { return of.object.name == object.name; });
    if (admits == truth->objects.end()) continue;  // furniture
    ++count.objects;
    if (admits->grasps.empty()) continue;
    ++count.graspable;
    const grasp::ObjectPlan* found = PlanFor(object, *plan);
    if (found == nullptr) {
      count.Fail(seed, object.name, "not found", "");
    } else if (found->grasps.empty()) {
      count.Fail(seed, object.name, "no grasp", found->failure_reason);
    } else {
      const grasp::Assessment assessed =
          AssessBestGrasp(truly, request, object.name, found->grasps.front());
      if (assessed.failure == grasp::GraspFailure::kNone) {
        const PointChecker points(view.scene, grasp::MakeGraspQuery(request));
        if (points.Confirms(found->grasps.front().candidate.X_FG, object.name)) {
          ++count.confirmed;
        } else {
          count.Fail(seed, object.name, "denied by points",
                     found->grasps.front().candidate.strategy);
        }
      } else {
        count.Fail(
            seed, object.name, NameOf(assessed.failure),
            assessed.obstacle + " by a grasp of " + found->grasps.front().candidate.strategy);
      }
    }
  }
  DeleteWorld(connection, seen);
  DeleteWorld(connection, true_world);
  return true;
}

}  // namespace

void MeasureGraspsOn(const Seeds& seeds, Report& report) {
  const RunningServer server;
  if (!server.up()) return report.Fail("grasps: cwm-server did not start");
  Count count;
  try {
    for (int i = 0; i < seeds.count; ++i) {
      if (!MeasureTable(server.connection(), seeds.first + static_cast<std::uint64_t>(i), count)) {
        return report.Fail("grasps: table " + std::to_string(seeds.first + i) +
                           " could not be asked");
      }
    }
  } catch (const api::Error& error) {
    return report.Fail(std::string("grasps: ") + error.what());
  }
  if (count.graspable == 0) return report.Fail("grasps: nothing could be taken");
  std::string detail = "Grasps on " + std::to_string(seeds.count) + " tables: of " +
                       std::to_string(count.objects) + " things " +
                       std::to_string(count.graspable) + " can be taken, " +
                       std::to_string(count.confirmed) + " are";
  for (const auto& [what, times] : count.failures) {
    detail += "; " + what + " " + std::to_string(times);
  }
  report.Detail(detail);
  report.Attach("grasp_failures.txt", count.lines);
  report.Add({.key = "grasp_success",
              .value = static_cast<double>(count.confirmed) / count.graspable,
              .unit = "1",
              .how = "share of the things on simulated tables that the planner can take when it is "
                     "given their true shapes, whose best grasp from one Kinect scan closes on the "
                     "true thing within friction and hits nothing true on its way: by certified "
                     "motions and rays in a "
                     "world of the true shapes, and by points and the shapes' formulas"});
}

void MeasureGrasps(Report& report) { MeasureGraspsOn(kSeedsOfGrasps, report); }

}  // namespace cwm::benchmarks
