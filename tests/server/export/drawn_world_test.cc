// GLB and PLY, read back by independent readers.
#include "server/export/drawn_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "clients/formats/ply.h"
#include "collision/mesh_files/glb_file.h"
#include "collision/query/query.h"
#include "server/core/error.h"
#include "tests/collision/world/test_arm.h"
#include "tests/server/export/world_of_all.h"

namespace cwm::server {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::shared_ptr<const collision::WorldSnapshot> WithArm(
    const std::shared_ptr<const collision::WorldSnapshot>& world) {
  auto arm = collision::testing::PutArm("crane");
  arm.X_WB = MakeTranslation(3, 0, 0);
  const std::vector<collision::Change> changes = {{arm, std::nullopt}};
  return *Apply(world, changes);
}

DrawnWorld Drawn(const collision::WorldSnapshot& snapshot) {
  auto drawn = DrawWorld(snapshot, 1'000'000);
  EXPECT_TRUE(drawn.ok()) << drawn.status();
  drawn->name = "room";
  return *drawn;
}

nlohmann::json JsonOf(const std::string& glb) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof(length));
  return nlohmann::json::parse(glb.substr(20, length));
}

// The distance of p_W from all bounded solids of the world.
double Distance_m(const collision::WorldSnapshot& world, const Vector3& p_W) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const auto& object : world.objects()) {
    for (const auto& part : object->geometry->parts) {
      if (std::holds_alternative<HalfSpace>(part.shape)) continue;
      const Vector3 p = (object->X_WO * part.X_OP).inverse() * p_W;
      const double distance_m = std::abs(SignedDistance_m(part.shape, p));
      nearest_m = std::min(nearest_m, distance_m);
    }
  }
  return nearest_m;
}

TEST(DrawnWorldTest, HasItsVerticesOnTheSurfacesInEachFormat) {
  const auto world = WorldOfAll();
  const DrawnWorld drawn = Drawn(*world);
  const auto glb = collision::ReadGlb(FormatGlb(drawn).value(), {});
  ASSERT_TRUE(glb.ok()) << glb.status();
  const Eigen::AngleAxisd to_z_up(std::numbers::pi / 2, Vector3::UnitX());
  ASSERT_GT(glb->vertices.size(), 1000u);
  for (const Vector3& vertex : glb->vertices) {
    EXPECT_LT(Distance_m(*world, to_z_up * vertex), 1e-6);
  }
  std::set<std::string> named;
  for (const DrawnItem& item : drawn.items) named.insert(item.name);
  for (const auto& object : world->objects()) {
    const bool is_drawn = object->name != "HalfSpace";  // "HalfSpace.2" has a sphere as well
    EXPECT_EQ(named.contains(object->name), is_drawn) << object->name;
  }
  const auto ply = formats::ParsePlyMesh(FormatPly(drawn).value(), "world.ply");
  ASSERT_TRUE(ply.ok()) << ply.status();
  EXPECT_EQ(ply->triangles.size(), glb->triangles.size());
  for (const auto& [x, y, z] : ply->vertices) EXPECT_LT(Distance_m(*world, {x, y, z}), 1e-12);
}

TEST(DrawnWorldTest, LeavesOutWhatHasNoEnd) {
  EXPECT_THAT(Drawn(*WorldOfAll()).warnings,
              ElementsAre(HasSubstr("HalfSpace, HalfSpace.2: a half-space is left out")));
}

TEST(GlbExport, NamesObjectsAndRobotsAndSaysWhatTheyAre) {
  const nlohmann::json json = JsonOf(FormatGlb(Drawn(*WithArm(WorldOfAll()))).value());
  std::map<std::string, nlohmann::json> by_name;
  for (const auto& node : json["nodes"]) by_name[node["name"]] = node;
  EXPECT_EQ(json["nodes"][0]["name"], "room");
  EXPECT_EQ(by_name.at("Cup")["extras"]["kind"], "USER");
  EXPECT_EQ(by_name.at("Cup")["extras"]["uid"], "Cup@1");
  EXPECT_TRUE(by_name.contains("crane"));
  EXPECT_GT(by_name.at("crane")["children"].size(), 1u);
  const auto link = by_name.at("crane")["children"][0].get<std::size_t>();
  EXPECT_TRUE(json["nodes"][link].contains("mesh"));
}

// Whether the objects share their geometry in memory makes no difference to the file: a restored
// server may share more of it than the one before.
TEST(GlbExport, SharesEqualMeshes) {
  const auto box = [](double edge_m) {
    return collision::BodyFromShapes({{.shape = Box{{edge_m, 0.1, 0.1}}}}).geometry;
  };
  const auto shared = box(0.1);
  std::vector<std::string> files;
  for (const auto& geometries :
       {std::vector{shared, shared, box(0.2)}, std::vector{box(0.1), box(0.1), box(0.2)}}) {
    std::vector<collision::Change> changes;
    for (const auto& geometry : geometries) {
      changes.push_back({collision::PutObject{.name = "box" + std::to_string(changes.size()),
                                              .geometry = geometry,
                                              .supported_by = {}},
                         std::nullopt});
    }
    const auto world = Apply(std::make_shared<const collision::WorldSnapshot>(), changes);
    files.push_back(FormatGlb(Drawn(**world)).value());
    EXPECT_EQ(JsonOf(files.back())["meshes"].size(), 2u);
  }
  EXPECT_EQ(files[0], files[1]);
}

TEST(GlbExport, OfAnEmptyWorldIsAnEmptyScene) {
  const DrawnWorld empty = Drawn(collision::WorldSnapshot());
  const nlohmann::json json = JsonOf(FormatGlb(empty).value());
  EXPECT_EQ(json["nodes"].size(), 1u);
  EXPECT_FALSE(json.contains("meshes"));
  EXPECT_THAT(FormatPly(empty).value(), HasSubstr("element face 0\n"));
}

TEST(PlyExport, NamesThings) {
  const std::string ply = FormatPly(Drawn(*WithArm(WorldOfAll()))).value();
  EXPECT_THAT(ply, HasSubstr("comment thing 0 Box\n"));
  EXPECT_THAT(ply, HasSubstr(" crane/"));
}

TEST(DrawnWorldTest, RefusesMoreTrianglesThanMayBe) {
  const auto drawn = DrawWorld(*WorldOfAll(), 100);
  EXPECT_EQ(drawn.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(drawn.status().message()), HasSubstr("at most 100"));
}

}  // namespace
}  // namespace cwm::server
