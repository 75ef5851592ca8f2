// Robots that would take much more memory than their files once they are prepared.
#include "collision/robot/prepared_budget.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "collision/robot/urdf.h"
#include "tests/collision/mesh_files/mesh_bytes.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using ::testing::HasSubstr;
using testing::JointText;
using testing::Robot;

std::string MeshText(const std::string& scale) {
  return "<collision><geometry><mesh filename=\"a.stl\" scale=\"" + scale +
         "\"/></geometry></collision>";
}

absl::Status StatusOf(const std::string& urdf, const std::string& stl = "",
                      const RobotLimits& limits = {}) {
  const auto source = [&](std::string_view) { return absl::StatusOr<std::string>(stl); };
  return ReadUrdf(urdf, source, limits).status();
}

std::string RefusalOf(const absl::Status& status) {
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  return std::string(status.message());
}

// 2000 triangles without common corners.
std::string Stl() {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < 6000; i += 3) {
    for (int k = 0; k < 3; ++k) mesh.vertices.emplace_back(i + k % 2, k / 2, 0);
    mesh.triangles.push_back({i, i + 1, i + 2});
  }
  return testing::BinaryStl(mesh);
}

TEST(PreparedBudget, EachScaleOfAMeshCounts) {
  const auto with_scales = [](int count) {
    std::string text = "<link name=\"a\">";
    for (int i = 1; i <= count; ++i) text += MeshText(absl::StrCat(i, " 1 1"));
    return Robot(text + "</link>");
  };
  EXPECT_EQ(StatusOf(with_scales(8), Stl()), absl::OkStatus());
  const std::string refusal = RefusalOf(StatusOf(with_scales(60), Stl()));
  EXPECT_THAT(refusal, HasSubstr("link \"a\": collision["));
  EXPECT_THAT(refusal, HasSubstr("bytes once it is prepared, must take at most "));
  EXPECT_THAT(refusal, HasSubstr(": 4194304 and 100 for each of the "));
}

TEST(PreparedBudget, OneScaleOfAMeshCountsOnce) {
  std::string text = "<link name=\"a\">";
  for (int i = 0; i < 60; ++i) text += MeshText("2 1 1");
  EXPECT_EQ(StatusOf(Robot(text + "</link>"), Stl()), absl::OkStatus());
}

// A mesh used a thousand times takes no further memory, but its triangles are visited each time.
TEST(PreparedBudget, TrianglesThatAreLookedAtOftenCount) {
  std::string text = "<link name=\"a\">";
  for (int i = 0; i < 1000; ++i) text += MeshText("2 1 1");
  EXPECT_THAT(RefusalOf(StatusOf(Robot(text + "</link>"), Stl())),
              HasSubstr("once it is prepared"));
}

TEST(PreparedBudget, PairsOfLinksCount) {
  const auto with_links = [](int count, const std::string& more) {
    std::string text;
    for (int i = 0; i < count; ++i) {
      absl::StrAppend(&text, "<link name=\"", i, "\"><collision><geometry><sphere radius=\"1\"/>",
                      "</geometry></collision>", more, "</link>");
      if (i > 0) text += JointText(absl::StrCat("j", i), "fixed", "0", absl::StrCat(i));
    }
    return Robot(text);
  };
  EXPECT_EQ(StatusOf(with_links(500, "")), absl::OkStatus());
  const RobotLimits pairs_alone{
      .max_links = 4'096, .max_free_prepared_bytes = 0, .max_prepared_per_byte = 40};
  EXPECT_EQ(StatusOf(with_links(500, ""), "", pairs_alone), absl::OkStatus());
  EXPECT_THAT(RefusalOf(StatusOf(with_links(4000, ""), "", pairs_alone)),
              HasSubstr("once it is prepared"));
}

TEST(PreparedBudget, LinksWithoutShapesCountToo) {
  std::string text = "<link name=\"0\"/>";
  for (int i = 1; i < 100; ++i) {
    absl::StrAppend(&text, "<link name=\"", i, "\"/>");
    text += JointText(absl::StrCat("j", i), "fixed", "0", absl::StrCat(i));
  }
  EXPECT_EQ(StatusOf(Robot(text)), absl::OkStatus());
  EXPECT_THAT(RefusalOf(StatusOf(Robot(text), "",
                                 {.max_free_prepared_bytes = 0, .max_prepared_per_byte = 1})),
              HasSubstr("urdf: the robot would take "));
}

}  // namespace
}  // namespace cwm::collision
