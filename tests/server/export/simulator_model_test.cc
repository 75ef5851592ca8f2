// URDF and SDFormat, read back and compared by signed distances.
#include "server/export/simulator_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tinyxml2.h>

#include <functional>
#include <map>
#include <random>
#include <sstream>

#include "collision/mesh_files/mesh_file.h"
#include "collision/robot/urdf.h"
#include "tests/server/export/world_of_all.h"

namespace cwm::server {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

// STL files contain floats.
constexpr double kFloat_m = 1e-7;
constexpr std::int64_t kAnyTriangles = 1'000'000;

ModelFiles Urdf() {
  auto scene = MakePlanningScene(*WorldOfAll(), 1'000'000);
  EXPECT_TRUE(scene.ok()) << scene.status();
  scene->name = "room/1";
  return FormatUrdf(*std::move(scene), kAnyTriangles).value();
}
ModelFiles Sdf() {
  auto scene = MakePlanningScene(*WorldOfAll(), 1'000'000);
  EXPECT_TRUE(scene.ok()) << scene.status();
  scene->name = "room/1";
  return FormatSdf(*std::move(scene), kAnyTriangles).value();
}

absl::StatusOr<std::string> FileOf(const ModelFiles& model, std::string_view name) {
  for (const NamedFile& file : model.files) {
    if (file.name == name) return file.bytes;
  }
  return absl::NotFoundError("must be one of the files beside");
}

// The parts of one object as read from the file.
using Parts = std::vector<Placed<>>;

double DistanceIn(const Parts& parts, const Vector3& p_W) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const auto& [X_WP, shape] : parts) {
    nearest_m = std::min(nearest_m, SignedDistance_m(shape, X_WP.inverse() * p_W));
  }
  return nearest_m;
}

// `without`: the name of a case that is not compared.
void ExpectSameGeometry(const std::map<std::string, Parts>& read, const std::string& without) {
  const auto world = WorldOfAll();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  ASSERT_EQ(read.size(), world->objects().size());
  for (const Case& c : Cases()) {
    if (c.name == without) continue;
    // Every cone becomes a mesh in these formats.
    const bool is_cone = std::holds_alternative<Cone>(c.shape);
    const double tolerance_m =
        kFloat_m + (is_cone ? std::max(c.tolerance_m, kDefaultDeviation_m) : c.tolerance_m);
    for (const std::string& name : {c.name, c.name + ".2"}) {
      ASSERT_TRUE(read.contains(name)) << name;
      for (int i = 0; i < 40; ++i) {
        const Vector3 p(coordinate(random), coordinate(random), coordinate(random));
        EXPECT_NEAR(DistanceIn(read.at(name), p), DistanceInObject(*world->Find(name), p),
                    tolerance_m)
            << name;
      }
    }
  }
}

TEST(UrdfExport, KeepsEveryShapeWhereItIs) {
  const ModelFiles model = Urdf();
  const auto robot = collision::ReadUrdf(model.files[0].bytes,
                                         [&](std::string_view uri) { return FileOf(model, uri); });
  ASSERT_TRUE(robot.ok()) << robot.status();
  EXPECT_EQ(robot->name, "room/1");
  std::map<std::string, Parts> read;
  for (const collision::Joint& joint : robot->joints) {
    EXPECT_EQ(joint.parent, "world");
    for (const collision::Link& link : robot->links) {
      if (link.name != joint.child) continue;
      for (const collision::CollisionGeometry& part : link.collisions) {
        read[link.name].push_back(Placed<>{joint.X_PJ * part.X_LG, part.shape});
      }
    }
  }
  ExpectSameGeometry(read, "HalfSpace");
  // The box's top face is the plane, so distances agree where the sides and the bottom are farther
  // away.
  const auto world = WorldOfAll();
  const Parts& ground = read.at("HalfSpace");
  for (const Vector3& p : {Vector3(0.1, 0.2, 0.3), Vector3(0.2, -0.1, 0.2)}) {
    const double distance_m = DistanceInObject(*world->Find("HalfSpace"), p);
    ASSERT_GT(distance_m, -0.4);
    EXPECT_NEAR(DistanceIn(ground, p), distance_m, kRounding_m);
  }
  EXPECT_THAT(model.warnings, Contains(HasSubstr("HalfSpace.2: a half-space ends after 10 m")));
}

Pose PoseOf(const tinyxml2::XMLElement& element) {
  std::istringstream text(element.FirstChildElement("pose")->GetText());
  Vector3 p, rpy;
  text >> p.x() >> p.y() >> p.z() >> rpy.x() >> rpy.y() >> rpy.z();
  Pose X = MakeTranslation(p.x(), p.y(), p.z());
  X.linear() =
      (Eigen::AngleAxisd(rpy.z(), Vector3::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Vector3::UnitY()) *
       Eigen::AngleAxisd(rpy.x(), Vector3::UnitX()))
          .toRotationMatrix();
  return X;
}

Shape ShapeOf(const tinyxml2::XMLElement& geometry, const ModelFiles& model) {
  const tinyxml2::XMLElement& shape = *geometry.FirstChildElement();
  const std::string kind = shape.Name();
  const auto number = [&](const char* name) { return shape.FirstChildElement(name)->DoubleText(); };
  if (kind == "sphere") return Sphere{number("radius")};
  if (kind == "cylinder") return Cylinder{number("radius"), number("length")};
  if (kind == "plane") return HalfSpace{};
  if (kind == "box") {
    std::istringstream text(shape.FirstChildElement("size")->GetText());
    Vector3 size_m;
    text >> size_m.x() >> size_m.y() >> size_m.z();
    return Box{size_m};
  }
  EXPECT_EQ(kind, "mesh");
  const std::string uri = shape.FirstChildElement("uri")->GetText();
  return MakeMesh(*collision::ReadMeshFile(FileOf(model, uri).value(), uri));
}

TEST(SdfExport, KeepsEveryShapeWhereItIs) {
  const ModelFiles model = Sdf();
  tinyxml2::XMLDocument document;
  ASSERT_EQ(document.Parse(model.files[0].bytes.c_str()), tinyxml2::XML_SUCCESS);
  const tinyxml2::XMLElement& sdf = *document.RootElement();
  EXPECT_STREQ(sdf.Attribute("version"), "1.7");
  std::map<std::string, Parts> read;
  for (const auto* of = sdf.FirstChildElement("world")->FirstChildElement("model"); of != nullptr;
       of = of->NextSiblingElement("model")) {
    EXPECT_STREQ(of->FirstChildElement("static")->GetText(), "true");
    const tinyxml2::XMLElement& link = *of->FirstChildElement("link");
    for (const auto* part = link.FirstChildElement("collision"); part != nullptr;
         part = part->NextSiblingElement("collision")) {
      const Shape shape = ShapeOf(*part->FirstChildElement("geometry"), model);
      read[of->Attribute("name")].push_back(Placed<>{PoseOf(*of) * PoseOf(*part), shape});
    }
  }
  ExpectSameGeometry(read, "");
}

TEST(SimulatorModels, HaveEachMeshOnceInAFolderBeside) {
  const ModelFiles model = Urdf();
  EXPECT_EQ(model.files[0].name, "");
  ASSERT_GT(model.files.size(), 2u);
  for (std::size_t i = 1; i < model.files.size(); ++i) {
    EXPECT_THAT(model.files[i].name,
                ::testing::MatchesRegex("room_1_meshes/[0-9]+_[A-Za-z.2]+.stl"));
    EXPECT_THAT(model.files[0].bytes, HasSubstr(model.files[i].name));
    for (std::size_t other = 1; other < i; ++other) {
      EXPECT_NE(model.files[i].bytes, model.files[other].bytes)
          << model.files[i].name << " and " << model.files[other].name;
    }
  }
}

TEST(SimulatorModels, CountTheTrianglesOfConesToo) {
  PlanningScene scene;
  for (int i = 0; i < 3; ++i) {
    const PlannerPrimitive cone{.kind = PlannerPrimitive::Kind::kCone,
                                .dimensions_m = {0.1 + 0.01 * i, 0.05, 0},
                                .dimension_count = 2};
    scene.objects.push_back({.name = "cone" + std::to_string(i),
                             .shapes = {{.X_OS = Pose::Identity(), .shape = cone, .note = {}}}});
  }
  const auto triangles = static_cast<std::int64_t>(Tessellate(Cone{0.05, 0, 0.1}).triangles.size());
  EXPECT_TRUE(FormatUrdf(scene, 3 * triangles).ok());
  const auto refused = FormatSdf(scene, 3 * triangles - 1);
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("the meshes up to cone2 have"));
}

TEST(SdfExport, KeepsReservedNamesToTheFormat) {
  PlanningScene scene;
  scene.name = "world";
  for (const char* name : {"__model__", "world", "world_1"}) {
    scene.objects.push_back({.name = name, .shapes = {}});
  }
  const ModelFiles model = FormatSdf(scene, kAnyTriangles).value();
  for (const char* name : {"<world name=\"world_1\"", "<model name=\"__model___1\"",
                           "<model name=\"world_1_1\"", "<model name=\"world_1\""}) {
    EXPECT_THAT(model.files[0].bytes, HasSubstr(name));
  }
  EXPECT_THAT(model.warnings, Contains(HasSubstr("world: written as world_1_1")));
}

TEST(SimulatorModels, AreTheSameBytesEveryTime) {
  const ModelFiles first = Urdf(), second = Urdf();
  for (std::size_t i = 0; i < first.files.size(); ++i) {
    EXPECT_EQ(first.files[i].bytes, second.files[i].bytes);
  }
}

}  // namespace
}  // namespace cwm::server
