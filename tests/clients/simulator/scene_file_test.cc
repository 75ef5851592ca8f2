#include "clients/simulator/scene_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "clients/formats/file_bytes.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/random_draws.h"
#include "perception/simulation/virtual_scanner.h"
#include "tests/support/process.h"

namespace cwm::simulator {
namespace {

using perception::Finish;
using perception::PieceRole;
using perception::SceneFamily;
using perception::SimulatedObject;
using perception::SimulatedView;
using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::ScratchDirectory;
using ::testing::StartsWith;

// Poses are converted to quaternions: a few roundings of numbers of magnitude one.
constexpr double kRounding = 1e-14;

void ExpectSame(const SimulatedView& a, const SimulatedView& b) {
  EXPECT_EQ(a.camera.width, b.camera.width);
  EXPECT_EQ(a.camera.height, b.camera.height);
  EXPECT_EQ(a.camera.focal_px, b.camera.focal_px);
  EXPECT_EQ(a.camera.center_x_px, b.camera.center_x_px);
  EXPECT_EQ(a.camera.center_y_px, b.camera.center_y_px);
  EXPECT_TRUE(a.camera.X_WC.isApprox(b.camera.X_WC, kRounding));
  ASSERT_EQ(a.scene.objects.size(), b.scene.objects.size());
  for (std::size_t i = 0; i < a.scene.objects.size(); ++i) {
    const SimulatedObject& x = a.scene.objects[i];
    const SimulatedObject& y = b.scene.objects[i];
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.is_support, y.is_support);
    EXPECT_EQ(x.finish, y.finish);
    EXPECT_TRUE(x.X_WO.isApprox(y.X_WO, kRounding));
    ASSERT_EQ(x.parts.size(), y.parts.size());
    for (std::size_t part = 0; part < x.parts.size(); ++part) {
      EXPECT_EQ(x.parts[part].shape, y.parts[part].shape) << x.name;
      EXPECT_TRUE(x.parts[part].X_FS.isApprox(y.parts[part].X_FS, kRounding));
      EXPECT_EQ(x.RoleOf(part), y.RoleOf(part));
    }
  }
}

TEST(SceneFile, ReadsBackWhatItWrote) {
  const ScratchDirectory scratch;
  for (const SceneFamily family : {SceneFamily::kClutter, SceneFamily::kVessels}) {
    SimulatedView view = perception::RandomScene(family, 2);
    view.scene.objects[0].finish = Finish::kShiny;
    const std::string path = scratch / "scene.yaml";
    ASSERT_TRUE(WriteScene(path, view).ok());
    const auto read = ReadScene(path);
    ASSERT_TRUE(read.ok()) << read.status();
    ExpectSame(view, *read);
  }
}

TEST(SceneFile, ReadsBackEveryShapeAndAwkwardNames) {
  const ScratchDirectory scratch;
  SimulatedView view;
  view.camera.X_WC = perception::LookAt({1, 2, 3}, Vector3(0, 0.1, 0));
  const std::vector<Shape> shapes = {
      Sphere{.radius_m = 0.1},
      Box{.size_m = {0.1, 1.0 / 3, 1e-3}},
      Cylinder{.radius_m = 0.1, .length_m = 0.2},
      Cone{.radius_bottom_m = 0.1, .radius_top_m = 0, .length_m = 0.2},
      Capsule{.radius_m = 0.1, .length_m = 0.2},
      HalfSpace{},
      Plate{.outline = {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
            .holes = {{{0.2, 0.2}, {0.4, 0.2}, {0.4, 0.4}}},
            .thickness_m = 0.02}};
  const std::vector<std::string> names = {"a b", "\"quoted\"", "true", "12", "#x: y", "ä", "../up"};
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    view.scene.objects.push_back(
        {.name = names[i],
         .parts = {{.X_FS = MakeTranslation(0.1, -0.2, 1e-9), .shape = shapes[i]}},
         .X_WO = view.camera.X_WC});
  }
  const std::string path = scratch / "shapes.yaml";
  ASSERT_TRUE(WriteScene(path, view).ok());
  const auto read = ReadScene(path);
  ASSERT_TRUE(read.ok()) << read.status();
  ExpectSame(view, *read);
}

TEST(SceneFile, ReadsTheDocumentedExample) {
  const auto view = ReadScene("clients/simulator/example_scene.yaml");
  ASSERT_TRUE(view.ok()) << view.status();
  ASSERT_EQ(view->scene.objects.size(), 8U);
  EXPECT_EQ(view->camera.center_x_px, 319.5);
  std::vector<int> kinds(kShapeKindCount, 0);
  for (const SimulatedObject& object : view->scene.objects) {
    for (const Placed<>& part : object.parts) ++kinds[part.shape.index()];
  }
  for (int kind = 0; kind < kShapeKindCount; ++kind) {
    if (kind == static_cast<int>(ShapeKind::kConvex)) continue;  // hulls are written as meshes
    EXPECT_GT(kinds[static_cast<std::size_t>(kind)], 0) << NameOf(static_cast<ShapeKind>(kind));
  }
  const SimulatedObject& mug = view->scene.objects[6];
  EXPECT_EQ(mug.RoleOf(1), PieceRole::kHandle);
  const Mesh& handle = std::get<Mesh>(mug.parts[1].shape);
  EXPECT_TRUE(handle.watertight);
  // 12 mm wide; the handle's outline is 32 x 55 mm less 24 x 39 mm.
  EXPECT_NEAR(SignedVolume_m3(*handle.mesh), 0.012 * (0.032 * 0.055 - 0.024 * 0.039), 1e-12);
  // All objects but the shiny one are visible.
  const auto scan = perception::Scan(view->scene, view->camera, {});
  for (std::size_t i = 0; i < view->scene.objects.size(); ++i) {
    const auto points =
        std::count(scan.object.begin(), scan.object.end(), static_cast<std::int32_t>(i));
    EXPECT_EQ(points > 200, view->scene.objects[i].finish == Finish::kMatt)
        << view->scene.objects[i].name << " " << points;
  }
}

// The URDF convention: roll, then pitch, then yaw, about fixed axes.
TEST(SceneFile, TurnsByRollThenPitchThenYaw) {
  const ScratchDirectory scratch;
  const std::string path = scratch / "turned.yaml";
  const std::string yaml =
      "camera: {width: 4, height: 4, focal_px: 4, pose: {}}\n"
      "objects:\n"
      "  - name: box\n"
      "    pose: {rpy_deg: [90, 0, 90]}\n"
      "    parts: [{box: {size_m: [1, 2, 3]}}]\n";
  ASSERT_TRUE(formats::WriteFileBytes(path, yaml).ok());
  const auto view = ReadScene(path);
  ASSERT_TRUE(view.ok()) << view.status();
  const Matrix3 R = view->scene.objects[0].X_WO.linear();
  // Roll takes y to z; yaw keeps z, takes x to y, and takes the former z (now -y) to x.
  EXPECT_NEAR((R * Vector3::UnitY() - Vector3::UnitZ()).norm(), 0, 1e-12);
  EXPECT_NEAR((R * Vector3::UnitX() - Vector3::UnitY()).norm(), 0, 1e-12);
  EXPECT_NEAR((R * Vector3::UnitZ() - Vector3::UnitX()).norm(), 0, 1e-12);
}

struct InvalidFile {
  std::string name;
  std::string from;  // a part of the valid scene ...
  std::string to;    // ... and its replacement
  std::string says;
};

constexpr const char* kGood =
    "camera:\n"                                                                  // 1
    "  width: 64\n"                                                              // 2
    "  height: 48\n"                                                             // 3
    "  focal_px: 52.5\n"                                                         // 4
    "  look_at: {from_m: [-1, 0, 1], at_m: [0, 0, 0]}\n"                         // 5
    "objects:\n"                                                                 // 6
    "  - name: table\n"                                                          // 7
    "    support: true\n"                                                        // 8
    "    parts:\n"                                                               // 9
    "      - plate: {outline_m: [[0, 0], [1, 0], [1, 1]], thickness_m: 0.02}\n"  // 10
    "  - name: can\n"                                                            // 11
    "    pose: {position_m: [0, 0, 0.1], quaternion_xyzw: [0, 0, 0, 1]}\n"       // 12
    "    parts:\n"                                                               // 13
    "      - cylinder: {radius_m: 0.04, length_m: 0.1}\n"                        // 14
    "        role: body\n";                                                      // 15

class InvalidFiles : public ::testing::TestWithParam<InvalidFile> {};

TEST_P(InvalidFiles, AreRefusedWithFileLineFieldValueAndRule) {
  const ScratchDirectory scratch;
  const std::string path = scratch / "invalid.yaml";
  std::string yaml = kGood;
  const std::size_t place = yaml.find(GetParam().from);
  ASSERT_NE(place, std::string::npos);
  yaml.replace(place, GetParam().from.size(), GetParam().to);
  ASSERT_TRUE(formats::WriteFileBytes(path, yaml).ok());
  const auto view = ReadScene(path);
  EXPECT_EQ(view.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(view.status().message()),
              AllOf(StartsWith(path + ":"), HasSubstr(GetParam().says)));
}

INSTANTIATE_TEST_SUITE_P(
    Table, InvalidFiles,
    ::testing::Values(
        InvalidFile{"UnknownKey", "support", "supports",
                    ":8: objects[0].supports is no known key; known"},
        InvalidFile{"UnknownTopKey", "camera:", "lens: 1\ncamera:", ":1: lens is no known key"},
        InvalidFile{"KeyTwice", "  height: 48\n", "  height: 48\n  width: 3\n",
                    ":4: camera.width stands here twice"},
        InvalidFile{"TextForNumber", "radius_m: 0.04", "radius_m: thin",
                    ":14: objects[1].parts[0].cylinder.radius_m is thin, must be a finite number"},
        InvalidFile{"NotANumber", "radius_m: 0.04", "radius_m: .nan", "must be a finite number"},
        InvalidFile{"Nan", "radius_m: 0.04", "radius_m: nan",
                    "radius_m is nan, must be a finite number"},
        InvalidFile{"Infinite", "length_m: 0.1", "length_m: inf",
                    "length_m is inf, must be a finite"},
        InvalidFile{"NegativeSize", "radius_m: 0.04", "radius_m: -0.04",
                    ":14: objects[1].parts[0].cylinder.radius_m is -0.04, must be positive"},
        InvalidFile{"ZeroSize", "length_m: 0.1", "length_m: 0", "length_m is 0, must be positive"},
        InvalidFile{"MissingSize", ", length_m: 0.1", "", "cylinder.length_m is missing"},
        InvalidFile{"NoThickness", "thickness_m: 0.02", "thickness_m: 0",
                    "thickness_m is 0, must be"},
        InvalidFile{"CrossingOutline", "[[0, 0], [1, 0], [1, 1]]",
                    "[[0, 0], [1, 1], [1, 0], [0, 1]]", "must be a simple polygon"},
        InvalidFile{"ShortVertex", "[1, 0], [1, 1]", "[1], [1, 1]", "must be a list of 2 numbers"},
        InvalidFile{"ShortPosition", "[0, 0, 0.1]", "[0, 0]",
                    ":12: objects[1].pose.position_m must be a list of 3 numbers"},
        InvalidFile{"LongQuaternion", "[0, 0, 0, 1]", "[0, 0, 1, 1]", "must be within 1 % of 1"},
        InvalidFile{"TwoRotations", "quaternion_xyzw", "rpy_deg: [0, 0, 0], quaternion_xyzw",
                    "must not stand beside quaternion_xyzw"},
        InvalidFile{"NoWidth", "  width: 64\n", "", "camera.width is missing"},
        InvalidFile{"HugeWidth", "width: 64", "width: 1000000",
                    ":2: camera.width is 1000000, must be a whole number from 1 to 4096"},
        InvalidFile{"FractionOfAPixel", "width: 64", "width: 64.5", "must be a whole number"},
        InvalidFile{"NoFocalLength", "focal_px: 52.5", "focal_px: 0",
                    "focal_px is 0, must be positive"},
        InvalidFile{"LooksAtItself", "at_m: [0, 0, 0]", "at_m: [-1, 0, 1]",
                    "must differ from from_m"},
        InvalidFile{"TwoCameraPoses", "  look_at", "  pose: {}\n  look_at",
                    "either pose or look_at"},
        InvalidFile{"NameTwice", "name: can", "name: table",
                    ":11: objects[1].name is table, must not appear twice"},
        InvalidFile{"NoName", "name: can", "name: \"\"", "objects[1].name"},
        InvalidFile{"FlagAsNumber", "support: true", "support: 1",
                    ":8: objects[0].support is 1, must be true or false"},
        InvalidFile{"UnknownRole", "role: body", "role: lid",
                    ":15: objects[1].parts[0].role is lid, must be body, handle or spout"},
        InvalidFile{"TwoShapes", "        role: body", "        sphere: {radius_m: 1}",
                    ":14: objects[1].parts[0] must hold one shape, and only one"},
        InvalidFile{"UnknownShape",
                    "cylinder:", "tube:", "objects[1].parts[0].tube is no known key"},
        InvalidFile{"MissingMesh", "cylinder: {radius_m: 0.04, length_m: 0.1}",
                    "mesh: {file: no.ply}",
                    ":14: objects[1].parts[0].mesh.file is no.ply, cannot be used"},
        InvalidFile{"MeshOfAnotherFormat", "cylinder: {radius_m: 0.04, length_m: 0.1}",
                    "mesh: {file: invalid.yaml}", "must be .stl, .obj, .dae, .glb or .ply"},
        InvalidFile{"MeshScaledAway", "cylinder: {radius_m: 0.04, length_m: 0.1}",
                    "mesh: {file: no.ply, scale: 0}", "scale is 0, must be positive"},
        InvalidFile{"ObjectsAsMap", "objects:\n", "objects: {}\nothers:\n",
                    "others is no known key"},
        InvalidFile{"NotYaml", "camera:", "camera: [", "YAML"},
        InvalidFile{"OtherDocument", kGood, "just text",
                    "the document is just text, must be a map"},
        InvalidFile{"Nothing", kGood, "", "the document must be a map"}),
    [](const auto& info) { return info.param.name; });

TEST(SceneFile, IsRefusedWhereThereIsNone) {
  EXPECT_EQ(ReadScene("no/such/scene.yaml").status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(ReadScene("no/such/scene.yaml").status().message()),
              HasSubstr("no/such/scene.yaml"));
}

TEST(SceneFile, IsReadUpToEveryByteWithoutHarm) {
  const ScratchDirectory scratch;
  const std::string path = scratch / "cut.yaml";
  const std::string good = kGood;
  for (std::size_t length = 0; length < good.size(); length += 3) {
    ASSERT_TRUE(formats::WriteFileBytes(path, good.substr(0, length)).ok());
    const auto view = ReadScene(path);
    if (!view.ok()) {
      EXPECT_THAT(std::string(view.status().message()), StartsWith(path));
    }
  }
}

// Bytes are changed, removed and duplicated at random: the scene is read, or the error has the
// place.
TEST(SceneFile, IsReadDamagedWithoutHarm) {
  const ScratchDirectory scratch;
  const std::string path = scratch / "damaged.yaml";
  perception::RandomDraws draws(1, 0);
  const std::string letters = "0-.:,[]{}&*#'\"\n \tae!%@|>?";
  for (int i = 0; i < 500; ++i) {
    std::string yaml = kGood;
    for (int change = draws.Below(4); change >= 0; --change) {
      const auto place = static_cast<std::size_t>(draws.Below(static_cast<int>(yaml.size())));
      const auto letter = static_cast<std::size_t>(draws.Below(static_cast<int>(letters.size())));
      const int kind = draws.Below(3);
      if (kind == 0) yaml[place] = letters[letter];
      if (kind == 1) yaml.erase(place, 1);
      if (kind == 2) yaml.insert(place, 1, letters[letter]);
    }
    ASSERT_TRUE(formats::WriteFileBytes(path, yaml).ok());
    const auto view = ReadScene(path);
    if (view.ok()) continue;
    EXPECT_EQ(view.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(view.status().message()), StartsWith(path + ":")) << yaml;
  }
}

// YAML aliases: a few lines that expand to more parts than are allowed.
TEST(SceneFile, IsRefusedBeyondTheMostParts) {
  const ScratchDirectory scratch;
  const std::string path = scratch / "many.yaml";
  std::string yaml = "camera: {width: 4, height: 4, focal_px: 4, pose: {}}\nobjects:\n";
  std::string parts = "&parts [";
  for (int i = 0; i < 1000; ++i) parts += "{sphere: {radius_m: 1}},";
  for (int i = 0; i < 200; ++i) {
    yaml += "  - {name: o" + std::to_string(i) + ", parts: " + (i == 0 ? parts + "]" : "*parts") +
            "}\n";
  }
  ASSERT_TRUE(formats::WriteFileBytes(path, yaml).ok());
  EXPECT_THAT(std::string(ReadScene(path).status().message()), HasSubstr("100000 parts"));
}

}  // namespace
}  // namespace cwm::simulator
