// A virtual Kinect scans scenes with known ground truth; the server must find their objects.
#include <algorithm>
#include <cmath>
#include <map>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using nlohmann::json;

struct Position {
  double x, y, z;
};

Position PositionOf(const json& pose) {
  return {pose.at("tx_m"), pose.at("ty_m"), pose.at("tz_m")};
}

// derived: a found object matches a true one if the centres of their bounds are horizontally within
// this distance, half the side of the smallest object of the scene.
constexpr double kSamePlace_m = 0.03;

// The centre of an object's bounds in the world. The server's bounds are in the object's frame.
Position CentreOf(const json& object) {
  const Position o = PositionOf(object.at("x_world_object"));
  const json& pose = object.at("x_world_object");
  const Position c = PositionOf(object.at("bounds").at("x_object_box"));
  const double x = pose.at("qx"), y = pose.at("qy"), z = pose.at("qz"), w = pose.at("qw");
  const double tx = 2 * (y * c.z - z * c.y), ty = 2 * (z * c.x - x * c.z),
               tz = 2 * (x * c.y - y * c.x);
  return {o.x + c.x + w * tx + y * tz - z * ty, o.y + c.y + w * ty + z * tx - x * tz,
          o.z + c.z + w * tz + x * ty - y * tx};
}

double Horizontal_m(const Position& a, const Position& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

// Compares radii and lengths by the names of their fields, and the edges of a box in order of size,
// since its axes have no names. The tolerances are the errors that 19 of 20 shapes at this distance
// should not exceed.
void ExpectDimensions(const json& found, const json& expected, const std::string& name) {
  constexpr double kRadius_m = 0.0025, kLength_m = 0.006;
  std::vector<double> found_edges, true_edges;
  for (const auto& [field, value] : found.items()) {
    const double truth = expected.at(field);
    if (field.rfind("size_", 0) == 0) {
      found_edges.push_back(value);
      true_edges.push_back(truth);
    } else {
      EXPECT_NEAR(value.get<double>(), truth,
                  field.rfind("radius_", 0) == 0 ? kRadius_m : kLength_m)
          << name << " " << field;
    }
  }
  std::sort(found_edges.begin(), found_edges.end());
  std::sort(true_edges.begin(), true_edges.end());
  for (std::size_t k = 0; k < true_edges.size(); ++k) {
    EXPECT_NEAR(found_edges[k], true_edges[k], kLength_m) << name << " edge " << k;
  }
}

class SimulatedScan : public ServerTest {};

TEST_F(SimulatedScan, KitchenIsFoundAsItStands) {
  const std::string cloud = Simulate("kitchen", {"--scene", "kitchen", "--seed", "3"});
  const json truth = Truth("kitchen");
  const json ingest =
      CwmJson({"ingest", cloud, "--x-world-sensor", PoseArgument(truth.at("x_world_sensor"))});
  ASSERT_TRUE(ingest.is_object());
  EXPECT_EQ(ingest.at("report").at("points_in"), "307200");

  // Supports: the counter top at its height. A wall behind it and a cabinet below it may be found,
  // too.
  std::vector<json> true_objects;
  std::size_t fixtures = 0;
  double counter_z = 0;
  for (const json& object : truth.at("objects")) {
    if (object.at("is_support").get<bool>()) {
      counter_z = object.at("top_z_m");
    } else if (object.at("name") == "wall" || object.at("name") == "cabinet") {
      ++fixtures;
    } else if (object.at("visible_points").get<int>() >= 300) {
      true_objects.push_back(object);
    }
  }
  ASSERT_EQ(ingest.at("supports").size(), 1U);
  // derived: the plane's height is the mean of tens of thousands of correlated points, well below
  // one sigma at 1 m (1.9 mm).
  EXPECT_NEAR(PositionOf(ingest["supports"][0]["x_world_object"]).z, counter_z, 0.003);

  // Objects: each true one has a found one at its place, and there are no others.
  std::size_t found_objects = 0;
  for (const json& found : ingest.at("objects"))
    found_objects += found.at("kind") == "OBJECT_KIND_OBJECT";
  EXPECT_GE(found_objects, true_objects.size());
  EXPECT_LE(found_objects, true_objects.size() + fixtures);
  for (const json& expected : true_objects) {
    const Position place = PositionOf(expected.at("centre"));
    int here = 0;
    for (const json& found : ingest.at("objects")) {
      if (found.at("kind") != "OBJECT_KIND_OBJECT") continue;
      if (Horizontal_m(CentreOf(found), place) > kSamePlace_m) continue;
      ++here;
      EXPECT_EQ(found.at("supported_by"), ingest["supports"][0].at("name"));
      ASSERT_FALSE(found.at("shapes").empty()) << expected.at("name");
      const json& part = found["shapes"][0];
      const std::string shape = expected.at("main_shape");
      ASSERT_TRUE(part.contains(shape)) << expected.at("name") << " was found as " << part.dump();
      ExpectDimensions(part[shape], expected.at("parts").at(0), expected.at("name"));
    }
    EXPECT_EQ(here, 1) << expected.at("name");
  }
}

TEST_F(SimulatedScan, EveryFinitePointIsAccountedFor) {
  const std::string cloud = Simulate("table", {"--scene", "table", "--seed", "5"});
  const json report = CwmJson({"ingest", cloud}).at("report");
  const auto count = [&](const char* key) { return std::stoll(report.at(key).get<std::string>()); };
  EXPECT_GT(count("points_finite"), 0);
  EXPECT_LE(count("points_rejected"),
            count("points_finite") / 200);  // isolated mixed pixels: 0.5 %
  // Points that are neither explained nor rejected are not within tolerance of any surface: at most
  // 0.1 %.
  EXPECT_GE(count("points_explained") + count("points_rejected"),
            count("points_finite") * 999 / 1000);
}

TEST_F(SimulatedScan, SegmentingLeavesTheWorldAsItIs) {
  const std::string cloud = Simulate("kitchen", {"--scene", "kitchen", "--seed", "4"});
  const ProcessResult segment = Cwm({"segment", cloud, scratch() / "labelled.pcd"});
  ASSERT_EQ(segment.exit_code, 0) << segment.err;
  EXPECT_LE(RevisionOf("default"), 0) << "segmenting must not put anything into the world";
}

}  // namespace
}  // namespace cwm::testing
