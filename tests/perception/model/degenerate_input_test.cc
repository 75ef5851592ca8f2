// Inputs that contain no shape.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "perception/modeler/object_modeler.h"
#include "perception/simulation/random_draws.h"

namespace cwm::perception {
namespace {

const SensorNoise kNoise;

OrientedPoints Degenerate(const std::vector<Eigen::Vector3f>& positions,
                          const Eigen::Vector3f& normal) {
  OrientedPoints points;
  for (const Eigen::Vector3f& p : positions) {
    points.points.push_back(p);
    points.normals.push_back(normal);
    points.sigma_m.push_back(0.002f);
    points.normal_sigma_rad.push_back(0.05f);
    points.cloud_index.push_back(0);
  }
  return points;
}

TEST(ModelObject, DegenerateInputsExplainNothingAndDoNoHarm) {
  const Eigen::Vector3f up = Eigen::Vector3f::UnitZ();
  std::vector<Eigen::Vector3f> line, scatter;
  RandomDraws draws(13, 0);
  for (int i = 0; i < 500; ++i) {
    line.emplace_back(0.001f * static_cast<float>(i), 0, 0);
    scatter.push_back(Vector3{draws.Uniform(), draws.Uniform(), draws.Uniform()}.cast<float>());
  }
  const std::vector<OrientedPoints> inputs = {
      {},
      Degenerate({Eigen::Vector3f::Zero()}, up),
      Degenerate(std::vector<Eigen::Vector3f>(1000, Eigen::Vector3f(1, 2, 3)), up),
      Degenerate(line, up),
      Degenerate(scatter, Eigen::Vector3f::Zero()),
      Degenerate(std::vector<Eigen::Vector3f>(100, Eigen::Vector3f::Constant(NAN)), up)};
  for (const OrientedPoints& points : inputs) {
    for (const std::optional<Pose>& support :
         {std::optional<Pose>(), std::optional<Pose>(Pose::Identity())}) {
      const ObjectModel model = ModelObject(points, support, kNoise, ModelerOptions{});
      EXPECT_EQ(model.part_of_point.size(), points.size());
      EXPECT_TRUE(model.shapes.empty());
      EXPECT_TRUE(model.handles.empty());
    }
  }
}

}  // namespace
}  // namespace cwm::perception
