// An arm of spheres with every kind of joint that SIMD code places.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "collision/query/query.h"
#include "collision/robot/urdf.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {

inline std::shared_ptr<const RobotModel> ModelOf(const std::string& text) {
  const auto description = ReadUrdf(testing::Robot(text), testing::NoMeshes);
  EXPECT_TRUE(description.ok()) << description.status();
  return *MakeRobotModel(*description, nullptr);
}

// A rail, a rotary joint without limits, three more rotary joints of which the last two are
// coupled, and an inclined tool.
inline std::shared_ptr<const RobotModel> SphereArm() {
  const auto turn = [](const std::string& axis, const std::string& more) {
    return "<origin xyz=\"0.1 0.05 0.2\" rpy=\"0.3 -0.2 0.7\"/><axis xyz=\"" + axis + "\"/>" + more;
  };
  const std::string limits = "<limit lower=\"-2.5\" upper=\"2.9\"/>";
  return ModelOf(
      testing::Links("abcdefg") +
      testing::JointText("rail", "prismatic", "a", "b",
                         "<axis xyz=\"0 1 0\"/><limit lower=\"-0.3\" upper=\"0.4\"/>") +
      testing::JointText("waist", "continuous", "b", "c", turn("0 0 1", "")) +
      testing::JointText("shoulder", "revolute", "c", "d", turn("0.6 0 0.8", limits)) +
      testing::JointText("elbow", "revolute", "d", "e", turn("0 1 0", limits)) +
      testing::JointText(
          "wrist", "revolute", "e", "f",
          turn("0 -1 0", limits + "<mimic joint=\"elbow\" multiplier=\"-0.5\" offset=\"0.1\"/>")) +
      testing::JointText("tool", "fixed", "f", "g",
                         "<origin xyz=\"0 0.02 0.1\" rpy=\"1 0 0.5\"/>"));
}

// Five spheres along each link, and all pairs of links that are not neighbours.
inline QueryBody BodyOfSphereArm(const RobotModel& model) {
  std::vector<Placed<>> shapes;
  QueryBody body;
  std::vector<int> link_of;
  for (int link = 0; link < static_cast<int>(model.links.size()); ++link) {
    for (int k = 0; k < 5; ++k) {
      shapes.push_back({.X_FS = MakeTranslation(0.02 * k, 0.01 * k, 0.05 * k),
                        .shape = Sphere{0.03 + 0.003 * k}});
      link_of.push_back(link);
    }
  }
  const auto count = static_cast<std::int32_t>(shapes.size());
  body.geometry = BodyFromShapes(std::move(shapes)).geometry;
  body.frame_of_part = link_of;
  body.frame_count = static_cast<int>(model.links.size());
  for (std::int32_t a = 0; a < count; ++a) {
    for (std::int32_t b = a + 1; b < count; ++b) {
      if (link_of[static_cast<std::size_t>(a)] + 2 < link_of[static_cast<std::size_t>(b)]) {
        body.self_pairs.push_back({a, b});
      }
    }
  }
  return body;
}

}  // namespace cwm::collision
