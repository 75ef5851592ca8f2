#include "clients/simulator/simulated_files.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

namespace cwm::simulator {
namespace {

using Json = nlohmann::ordered_json;

Json PoseJson(const Pose& pose) {
  const Quaternion rotation(pose.linear());
  return {pose.translation().x(),
          pose.translation().y(),
          pose.translation().z(),
          rotation.x(),
          rotation.y(),
          rotation.z(),
          rotation.w()};
}

Json PolygonJson(const Polygon& polygon) {
  Json vertices = Json::array();
  for (const auto& vertex : polygon) vertices.push_back({vertex.x(), vertex.y()});
  return vertices;
}

struct DimensionsJson {
  // Of one member: {{name, value}} would be an array of two.
  static Json One(const char* name, const Json& value) {
    Json json;
    json[name] = value;
    return json;
  }

  Json operator()(const Sphere& sphere) const { return One("radius_m", sphere.radius_m); }
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
    return One("vertex_count", convex.hull->vertices.size());
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

}  // namespace

formats::CloudFile ToCloudFile(const perception::PointCloud& cloud) {
  formats::CloudFile file;
  for (const char* axis : {"x", "y", "z"}) file.fields.push_back({.name = axis});
  file.point_step = formats::LayOut(file.fields);
  file.width = cloud.width;
  file.height = cloud.height;
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
  file.bytes.resize(cloud.points.size() * file.point_step);
  std::memcpy(file.bytes.data(), cloud.points.data(), file.bytes.size());
  return file;
}

std::vector<std::uint32_t> TrueLabels(const perception::SimulatedScene& scene,
                                      const perception::SimulatedCloud& scan) {
  const std::vector<std::uint32_t> of_object = ObjectLabels(scene);
  std::vector<std::uint32_t> labels;
  labels.reserve(scan.object.size());
  for (const std::int32_t object : scan.object) {
    labels.push_back(object < 0 ? 0 : of_object[static_cast<std::size_t>(object)]);
  }
  return labels;
}

std::string TruthJson(const perception::SimulatedScene& scene,
                      const perception::PinholeCamera& camera,
                      const perception::SimulatedCloud& scan) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::int64_t> point_counts;
  for (std::size_t p = 0; p < scan.object.size(); ++p) {
    ++point_counts[{scan.object[p], scan.part[p]}];
  }
  const std::vector<std::uint32_t> labels = ObjectLabels(scene);
  Json objects = Json::array();
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const perception::SimulatedObject& object = scene.objects[o];
    Json parts = Json::array();
    std::int64_t total = 0;
    for (std::size_t part = 0; part < object.parts.size(); ++part) {
      const auto count =
          point_counts[{static_cast<std::int32_t>(o), static_cast<std::int32_t>(part)}];
      const Placed<>& placed = object.parts[part];
      Json json = {{"kind", std::string(NameOf(KindOf(placed.shape)))}};
      json.update(std::visit(DimensionsJson{}, placed.shape));
      json["x_object_shape"] = PoseJson(placed.X_FS);
      json["point_count"] = count;
      parts.push_back(std::move(json));
      total += count;
    }
    objects.push_back({{"name", object.name},
                       {"label", labels[o]},
                       {"is_support", object.is_support},
                       {"x_world_object", PoseJson(object.X_WO)},
                       {"point_count", total},
                       {"parts", std::move(parts)}});
  }
  const Json truth = {{"x_world_sensor", PoseJson(camera.X_WC)},
                      {"width", camera.width},
                      {"height", camera.height},
                      {"objects", std::move(objects)}};
  return truth.dump(1) + "\n";
}

}  // namespace cwm::simulator
