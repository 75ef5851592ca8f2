#include "clients/simulator/simulated_files.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "clients/simulator/scene_file.h"
#include "collision/geometry/aabb.h"
#include "perception/simulation/hidden_shares.h"

namespace cwm::simulator {
namespace {

using Json = nlohmann::ordered_json;
using perception::BoundsInWorld;

Json PointJson(const Vector3& point) {
  return {{"tx_m", point.x()}, {"ty_m", point.y()}, {"tz_m", point.z()}};
}

Json PoseJson(const Pose& pose) {
  const Quaternion rotation(pose.linear());
  Json json = PointJson(pose.translation());
  json.update(
      {{"qx", rotation.x()}, {"qy", rotation.y()}, {"qz", rotation.z()}, {"qw", rotation.w()}});
  return json;
}

Json PolygonJson(const Polygon& polygon) {
  Json vertices = Json::array();
  for (const auto& vertex : polygon) vertices.push_back({vertex.x(), vertex.y()});
  return vertices;
}

struct DimensionsJson {
  // A single member: {{name, value}} would be an array of two elements.
  static Json SingleField(const char* name, const Json& value) {
    Json json;
    json[name] = value;
    return json;
  }

  Json operator()(const Sphere& sphere) const { return SingleField("radius_m", sphere.radius_m); }
  Json operator()(const Box& box) const {
    return {
        {"size_x_m", box.size_m.x()}, {"size_y_m", box.size_m.y()}, {"size_z_m", box.size_m.z()}};
  }
  Json operator()(const Cylinder& cylinder) const {
    return {{"radius_m", cylinder.radius_m}, {"length_m", cylinder.length_m}};
  }
  Json operator()(const Cone& cone) const {
    return {{"radius_bottom_m", cone.radius_bottom_m},
            {"radius_top_m", cone.radius_top_m},
            {"length_m", cone.length_m}};
  }
  Json operator()(const Capsule& capsule) const {
    return {{"radius_m", capsule.radius_m}, {"length_m", capsule.length_m}};
  }
  Json operator()(const HalfSpace&) const { return Json::object(); }
  Json operator()(const Plate& plate) const {
    Json holes = Json::array();
    for (const Polygon& hole : plate.holes) holes.push_back(PolygonJson(hole));
    return {{"outline", PolygonJson(plate.outline)},
            {"holes", holes},
            {"thickness_m", plate.thickness_m}};
  }
  Json operator()(const Convex& convex) const {
    return SingleField("vertex_count", convex.hull->vertices.size());
  }
  Json operator()(const Mesh& mesh) const {
    return {{"vertex_count", mesh.mesh->vertices.size()},
            {"triangle_count", mesh.mesh->triangles.size()}};
  }
};

// The label of each object of the scene.
std::vector<std::uint32_t> ObjectLabels(const perception::SimulatedScene& scene) {
  std::vector<std::uint32_t> labels;
  std::uint32_t supports = 0;
  std::uint32_t objects = 0;
  for (const auto& object : scene.objects) {
    labels.push_back(object.is_support ? std::min(++supports, 9u) : 10 * (++objects + 1));
  }
  return labels;
}

// chosen: furniture is larger; the tallest object on a counter is a bottle or a box of half a
// metre.
constexpr double kMovableSize_m = 0.5;

bool IsMovable(const perception::SimulatedObject& object) {
  return !object.is_support && BoundsInWorld(object).sizes().maxCoeff() < kMovableSize_m;
}

// The movable object with the largest distance from its nearest neighbour, so that it can be moved
// a little without touching one; -1: none.
int MovableIndex(const perception::SimulatedScene& scene) {
  int best = -1;
  double best_gap_m = -1;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (!IsMovable(scene.objects[i])) continue;
    double gap_m = std::numeric_limits<double>::max();
    for (std::size_t j = 0; j < scene.objects.size(); ++j) {
      if (j == i || !IsMovable(scene.objects[j])) continue;
      gap_m = std::min(
          gap_m, BoundsInWorld(scene.objects[i]).exteriorDistance(BoundsInWorld(scene.objects[j])));
    }
    if (gap_m <= best_gap_m) continue;
    best_gap_m = gap_m;
    best = static_cast<int>(i);
  }
  return best;
}

using PointCounts = std::map<std::pair<std::int32_t, std::int32_t>, std::int64_t>;

PointCounts CountPoints(const perception::SimulatedCloud& scan) {
  PointCounts counts;
  for (std::size_t p = 0; p < scan.object.size(); ++p) ++counts[{scan.object[p], scan.part[p]}];
  return counts;
}

// The offset of a part's label from its object's label.
std::uint32_t PartLabel(const perception::SimulatedObject& object, std::size_t part) {
  if (object.is_support || object.parts.size() == 1) return 0;
  return static_cast<std::uint32_t>(std::min<std::size_t>(part + 1, 9));
}

Json PartJson(const Placed<>& part, std::int64_t visible_points) {
  Json json = {{"kind", std::string(cwm::NameOf(KindOf(part.shape)))}};
  json.update(std::visit(DimensionsJson{}, part.shape));
  json["x_object_shape"] = PoseJson(part.X_FS);
  json["visible_points"] = visible_points;
  return json;
}

struct ObjectTruth {
  std::int32_t index = 0;
  std::uint32_t label = 0;
  double hidden_share = 0;
};

Json ObjectJson(const perception::SimulatedObject& object, const ObjectTruth& truth,
                const PointCounts& counts) {
  Json parts = Json::array();
  std::int64_t visible_points = 0;
  for (std::size_t part = 0; part < object.parts.size(); ++part) {
    const auto found = counts.find({truth.index, static_cast<std::int32_t>(part)});
    const std::int64_t count = found == counts.end() ? 0 : found->second;
    Json json = PartJson(object.parts[part], count);
    json["role"] = std::string(PieceRoleName(object.RoleOf(part)));
    json["label"] = truth.label + PartLabel(object, part);
    parts.push_back(std::move(json));
    visible_points += count;
  }
  const Aabb bounds = BoundsInWorld(object);
  Json json = {{"name", object.name},
               {"is_support", object.is_support},
               {"shiny", object.finish == perception::Finish::kShiny},
               {"x_world_object", PoseJson(object.X_WO)},
               {"centre", PointJson(bounds.center())},
               {"size_m", {bounds.sizes().x(), bounds.sizes().y(), bounds.sizes().z()}},
               {"top_z_m", bounds.max().z()},
               {"visible_points", visible_points},
               {"hidden_fraction", truth.hidden_share},
               {"label", truth.label}};
  if (!parts.empty()) {
    json["main_shape"] = parts.front().at("kind");
    if (parts.front().contains("radius_m")) json["radius_m"] = parts.front().at("radius_m");
  }
  json["parts"] = std::move(parts);
  return json;
}

Json CameraJson(const perception::PinholeCamera& camera) {
  return {{"width", camera.width},
          {"height", camera.height},
          {"focal_px", camera.focal_px},
          {"center_x_px", camera.center_x_px},
          {"center_y_px", camera.center_y_px}};
}

Json ViewsJson(const SimulatedScan& scan) {
  Json views = Json::array();
  for (std::size_t i = 0; i < scan.X_WC.size(); ++i) {
    views.push_back({{"x_world_sensor", PoseJson(scan.X_WC[i])},
                     {"x_first_sensor_registered", PoseJson(scan.X_CC[i])}});
  }
  return views;
}

}  // namespace

formats::CloudFile ToCloudFile(const perception::PointCloud& cloud) {
  formats::CloudFile file;
  for (const char* axis : {"x", "y", "z"}) file.fields.push_back({.name = axis});
  file.point_step = formats::AssignOffsets(file.fields);
  file.width = cloud.width;
  file.height = cloud.height;
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
  file.bytes.resize(cloud.points.size() * file.point_step);
  if (!cloud.points.empty()) {
    std::memcpy(file.bytes.data(), cloud.points.front().data(), file.bytes.size());
  }
  return file;
}

std::vector<std::uint32_t> TrueLabels(const perception::SimulatedScene& scene,
                                      const perception::SimulatedCloud& scan) {
  const std::vector<std::uint32_t> of_object = ObjectLabels(scene);
  std::vector<std::uint32_t> labels;
  labels.reserve(scan.object.size());
  for (std::size_t p = 0; p < scan.object.size(); ++p) {
    if (scan.object[p] < 0) {
      labels.push_back(0);
      continue;
    }
    const auto object = static_cast<std::size_t>(scan.object[p]);
    labels.push_back(of_object[object] +
                     PartLabel(scene.objects[object], static_cast<std::size_t>(scan.part[p])));
  }
  return labels;
}

std::string TruthJson(const perception::SimulatedScene& scene,
                      const perception::PinholeCamera& camera, const SimulatedScan& scan) {
  const PointCounts counts = CountPoints(scan.cloud);
  const std::vector<std::uint32_t> labels = ObjectLabels(scene);
  const std::vector<double> hidden_shares = perception::HiddenShares(scene, camera);
  Json objects = Json::array();
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const ObjectTruth truth{.index = static_cast<std::int32_t>(i),
                            .label = labels[i],
                            .hidden_share = hidden_shares[i]};
    objects.push_back(ObjectJson(scene.objects[i], truth, counts));
  }
  Json truth = {{"x_world_sensor", PoseJson(camera.X_WC)},
                {"width", scan.cloud.cloud.width},
                {"height", scan.cloud.cloud.height},
                {"camera", CameraJson(camera)},
                {"up_sensor", {scan.up_C.x(), scan.up_C.y(), scan.up_C.z()}},
                {"movable_index", MovableIndex(scene)},
                {"objects", std::move(objects)}};
  if (scan.X_WC.size() > 1) truth["views"] = ViewsJson(scan);
  return truth.dump(1) + "\n";
}

}  // namespace cwm::simulator
