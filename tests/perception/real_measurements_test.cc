// Objects of known size on real scans (section VI of the paper compares found shapes with real
// measurements): the same packets and the same tin, scan after scan, standing, lying and on edge.
//
// The sizes were taken from the labelled points without any fit: heights above the table, and the
// smallest rectangle around a top face with 1 % of the points cut off at each end; medians over the
// scans that show both ends. The tin's radius is the radius of a circle with the area between the
// middles of its lid's pixels (93.6 to 95.1 mm in the five scans in which nothing hides any of it)
// plus half a pixel. The position of the lid's edge, sector by sector, gives the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>

#include "clients/formats/cloud_reader.h"
#include "perception/interpret_scene.h"
#include "tests/support/outside_data.h"

namespace cwm::perception {
namespace {

constexpr std::size_t kWidth = 640;
// The uncertainty of the true sizes plus the errors of the sensor at 0.7 to 1 m.
constexpr double kEdgeTolerance_m = 0.006, kRadiusTolerance_m = 0.0025;

struct Pixel {
  int scan = 0;
  std::size_t column = 0, row = 0;  // in the middle of the object
};

std::optional<SceneInterpretation> Interpret(const std::string& directory, int scan) {
  const auto file = formats::ReadCloud(directory + "/learn" + std::to_string(scan) + ".pcd");
  if (!file.ok()) return std::nullopt;
  const formats::CloudFile xyz = formats::SelectFields(*file, {"x", "y", "z"});
  PointCloud cloud;
  cloud.width = static_cast<int>(xyz.width);
  cloud.height = static_cast<int>(xyz.height);
  cloud.points.resize(static_cast<std::size_t>(xyz.size()));
  std::memcpy(cloud.points.data()->data(), xyz.bytes.data(),
              cloud.points.size() * sizeof(Eigen::Vector3f));
  auto scene = InterpretScene(cloud, {});
  if (!scene.ok()) return std::nullopt;
  return *std::move(scene);
}

// The shape with the most inliers of the object at the pixel; null if there is none.
const Shape* ShapeAt(const SceneInterpretation& scene, const Pixel& pixel) {
  const std::uint32_t label = scene.labels[pixel.row * kWidth + pixel.column];
  if (label < 20) return nullptr;
  const DetectedObject& object = scene.objects[label / 10 - 2];
  const auto largest = std::max_element(object.model->shapes.begin(), object.model->shapes.end(),
                                        [](const ShapePart& a, const ShapePart& b) {
                                          return (a.fit ? a.fit->inlier_count : 0) <
                                                 (b.fit ? b.fit->inlier_count : 0);
                                        });
  return largest == object.model->shapes.end() ? nullptr : &largest->shape;
}

class RealMeasurements : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ = cwm::testing::OutsideData("mosd/learn");
    if (!directory_) GTEST_SKIP() << "labelled Kinect scans (mosd/learn) are not in CWM_DATA";
  }

  // The shape at the pixel; empty if it is not of this kind.
  template <class S>
  std::optional<S> Found(const Pixel& pixel) const {
    const auto scene = Interpret(*directory_, pixel.scan);
    const Shape* shape = scene ? ShapeAt(*scene, pixel) : nullptr;
    const S* found = shape != nullptr ? std::get_if<S>(shape) : nullptr;
    return found != nullptr ? std::optional<S>(*found) : std::nullopt;
  }

  void ExpectBox(const Pixel& pixel, std::array<double, 3> edges_m) const {
    SCOPED_TRACE("learn" + std::to_string(pixel.scan));
    const auto box = Found<Box>(pixel);
    ASSERT_TRUE(box);
    std::array<double, 3> found_m{box->size_m.x(), box->size_m.y(), box->size_m.z()};
    std::sort(found_m.begin(), found_m.end());
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(found_m[k], edges_m[k], kEdgeTolerance_m);
  }

  std::optional<std::string> directory_;
};

TEST_F(RealMeasurements, APacketOfMuesliHasItsEdgesWhicheverWayItIsTurned) {
  for (const Pixel& at :
       {Pixel{2, 253, 266}, Pixel{3, 229, 297}, Pixel{4, 194, 270}, Pixel{13, 297, 271}}) {
    ExpectBox(at, {0.043, 0.127, 0.212});
  }
}

TEST_F(RealMeasurements, APacketOfFlakesHasItsEdgesStandingAndLying) {
  for (const Pixel& at : {Pixel{0, 273, 309}, Pixel{2, 284, 163}, Pixel{6, 252, 208},
                          Pixel{7, 250, 218}, Pixel{13, 363, 176}}) {
    ExpectBox(at, {0.060, 0.151, 0.241});
  }
}

TEST_F(RealMeasurements, APacketOfTeaHasItsEdges) {
  for (const Pixel& at : {Pixel{6, 249, 274}, Pixel{13, 214, 230}}) {
    ExpectBox(at, {0.061, 0.076, 0.149});
  }
}

TEST_F(RealMeasurements, ATinHasItsRadiusLyingOnEdgeAndUnderOtherObjects) {
  const double radius_m = 0.095;
  for (const Pixel& at :
       {Pixel{33, 229, 380}, Pixel{35, 300, 387}, Pixel{36, 151, 350}, Pixel{37, 131, 335},
        Pixel{38, 131, 335}, Pixel{39, 126, 347}, Pixel{40, 165, 353}, Pixel{41, 285, 403},
        Pixel{42, 286, 395}, Pixel{43, 292, 279}}) {
    SCOPED_TRACE("learn" + std::to_string(at.scan));
    const auto tin = Found<Cylinder>(at);
    ASSERT_TRUE(tin);
    EXPECT_NEAR(tin->radius_m, radius_m, kRadiusTolerance_m);
    EXPECT_NEAR(tin->length_m, 0.070, kEdgeTolerance_m);
  }
}

}  // namespace
}  // namespace cwm::perception
