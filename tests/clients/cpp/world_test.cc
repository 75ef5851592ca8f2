// Objects, changes, files and errors of the C++ client with a real server.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <vector>

#include "tests/clients/cpp/running_server.h"
#include "tests/e2e/two_link_arm.h"

namespace cwm::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Worlds : public ClientTest {
 protected:
  World world_ = Connect();
};

std::vector<std::string> NamesOf(const std::vector<Object>& objects) {
  std::vector<std::string> names;
  for (const Object& object : objects) names.push_back(object.name);
  return names;
}

TEST_F(Worlds, ReturnTheObjectsThatWerePut) {
  const Plate plate{.outline = (Polygon(2, 4) << 0, 1, 1, 0, 0, 0, 1, 1).finished(),
                    .thickness_m = 0.02};
  const std::int64_t revision =
      world_.Apply({Put{.name = "cup",
                        .body = {{Cylinder{0.04, 0.1}}, {Capsule{0.01, 0.05}, At(0.05, 0, 0)}},
                        .X_WO = At(1, 2, 3),
                        .margin_m = 0.01,
                        .supported_by = "table"},
                    Put{.name = "table", .body = plate}, Put{.name = "floor", .body = HalfSpace{}},
                    Put{.name = "unseen", .body = Box{1, 1, 1}, .kind = ObjectKind::kUnseen},
                    Put{.name = "cone", .body = Cone{0.05, 0, 0.1}}});
  EXPECT_EQ(revision, 1) << "all changes are one revision";
  EXPECT_THAT(NamesOf(world_.Objects()), ElementsAre("cone", "cup", "floor", "table", "unseen"));
  EXPECT_THAT(NamesOf(world_.Objects({.kinds = {ObjectKind::kUnseen}})), ElementsAre("unseen"));
  EXPECT_THAT(NamesOf(world_.Objects({.prefix = "c"})), ElementsAre("cone", "cup"));
  EXPECT_THAT(
      NamesOf(world_.Objects({.kinds = {ObjectKind::kUser},
                              .within = Eigen::AlignedBox3d(Eigen::Vector3d(0.9, 1.9, 2.9),
                                                            Eigen::Vector3d(1.1, 2.1, 3.1))})),
      ElementsAre("cup"));

  const Object cup = world_.Get("cup");
  EXPECT_EQ(cup.kind, ObjectKind::kUser);
  EXPECT_EQ(cup.owner, Owner::kUser);
  EXPECT_TRUE(cup.X_WO.isApprox(At(1, 2, 3)));
  EXPECT_EQ(cup.margin_m, 0.01);
  EXPECT_EQ(cup.supported_by, "table");
  EXPECT_EQ(cup.revision(), 1);
  ASSERT_EQ(cup.parts.size(), 2U);
  EXPECT_EQ(std::get<Cylinder>(cup.parts[0].shape).length_m, 0.1);
  EXPECT_EQ(std::get<Capsule>(cup.parts[1].shape).radius_m, 0.01);
  EXPECT_TRUE(cup.parts[1].X_OS.isApprox(At(0.05, 0, 0)));
  EXPECT_EQ(cup.parts[0].coefficients.size(), 7U) << "PCL's cylinder: q, a, r";
  EXPECT_FALSE(cup.parts[0].fit.has_value());
  EXPECT_EQ(std::get<Plate>(world_.Get("table").parts[0].shape).outline, plate.outline);
  EXPECT_FALSE(world_.Get("floor").bounds.has_value());
  EXPECT_EQ(std::get<Cone>(world_.Get("cone").parts[0].shape).radius_bottom_m, 0.05);
}

TEST_F(Worlds, ChangeOneAfterTheOther) {
  EXPECT_EQ(world_.Put("ball", Sphere{0.1}), 1);
  EXPECT_EQ(world_.Move("ball", At(0, 0, 1)), 2);
  EXPECT_EQ(world_.revision(), 2);
  EXPECT_EQ(world_.Get("ball").X_WO.translation().z(), 1);
  EXPECT_EQ(world_.Remove("ball"), 3);
  EXPECT_TRUE(world_.Objects().empty());
  EXPECT_EQ(world_.At(1).Get("ball").X_WO.translation().z(), 0);

  const Error conflict = ErrorOf(
      [&] { world_.Apply({Put{.name = "ball", .body = Sphere{0.1}}}, /*expected_revision=*/2); });
  EXPECT_EQ(conflict.code(), ErrorCode::kAborted);
  EXPECT_EQ(conflict.reason(), "REVISION_MISMATCH");
  EXPECT_TRUE(world_.Objects().empty()) << "nothing was changed";
}

TEST_F(Worlds, KeepRulesOfPairs) {
  world_.Put("ball", Sphere{0.1});
  world_.Put("box", Box{0.1, 0.1, 0.1});
  EXPECT_FALSE(world_.Check("ball").all_free());
  world_.Allow("ball", "box", /*expires_after_s=*/1000);
  EXPECT_TRUE(world_.Check("ball").all_free());
  ASSERT_EQ(world_.Rules().size(), 1U);
  EXPECT_TRUE(world_.Rules()[0].allowed);
  EXPECT_TRUE(world_.Rules()[0].expires.has_value());
  world_.Disallow("ball", "box");
  EXPECT_FALSE(world_.Check("ball").all_free());
  world_.Move("box", At(0.25, 0, 0));
  EXPECT_TRUE(world_.Check("ball").all_free()) << "0.1 m lie between them";
  world_.SetMargin("ball", "box", 0.2);
  EXPECT_EQ(world_.Rules()[0].margin_m, 0.2);
  EXPECT_FALSE(world_.Check("ball").all_free());
  world_.SetMargin("ball", "box", std::nullopt);
  EXPECT_TRUE(world_.Rules().empty());
}

TEST_F(Worlds, ListTheContactsOfAll) {
  world_.Put("a", Sphere{0.1});
  world_.Put("b", Sphere{0.1}, At(0.15, 0, 0));
  world_.Put("c", Sphere{0.1}, At(1, 0, 0));
  const WorldContacts contacts = world_.ContactsOfWorld();
  EXPECT_TRUE(contacts.is_complete);
  ASSERT_EQ(contacts.size(), 1);
  EXPECT_EQ(contacts.objects[static_cast<std::size_t>(contacts.object_a[0])].name, "a");
  EXPECT_EQ(contacts.objects[static_cast<std::size_t>(contacts.object_b[0])].name, "b");
  EXPECT_NEAR(contacts.distance_m[0], -0.05, 1e-9);
  EXPECT_TRUE(contacts.point_a.col(0).isApprox(Eigen::Vector3d(0.1, 0, 0), 1e-9));
  EXPECT_TRUE(contacts.point_b.col(0).isApprox(Eigen::Vector3d(0.05, 0, 0), 1e-9));
  EXPECT_TRUE(contacts.normal.col(0).isApprox(Eigen::Vector3d::UnitX(), 1e-9));
  EXPECT_EQ(contacts.trust[0], Trust::kExact);
  EXPECT_EQ(world_.WhatIf({Remove{"b"}}).ContactsOfWorld().size(), 0);
  EXPECT_EQ(world_.At().Stream().ContactsOfWorld({.margin_m = 1}).size(), 3) << "all pairs";
}

TEST_F(Worlds, ReadTheSurfaceOfAnObject) {
  world_.Put("box", Box{0.2, 0.4, 0.6}, At(5, 0, 0));
  const Mesh mesh = world_.ReadSurface("box");
  EXPECT_EQ(mesh.triangles.cols(), 12);
  EXPECT_EQ(mesh.vertices.rowwise().maxCoeff(), Eigen::Vector3d(0.1, 0.2, 0.3))
      << "in the object's frame";
}

TEST_F(Worlds, ExportFiles) {
  world_.Put("box", Box{0.2, 0.4, 0.6});
  const ExportResult glb = world_.Export(ExportFormat::kGlb);
  EXPECT_EQ(glb.bytes.substr(0, 4), "glTF");
  EXPECT_EQ(glb.revision, 1);
  const Mesh mesh = world_.ReadSurface("box");
  world_.Put("mesh", mesh);
  const ExportResult urdf = world_.Export(ExportFormat::kUrdf);
  ASSERT_EQ(urdf.files.size(), 1U);
  const std::string path = server().scratch() / "exported/world.urdf";
  std::filesystem::create_directories(server().scratch() / "exported");
  urdf.Save(path);
  EXPECT_EQ(std::filesystem::file_size(path), urdf.bytes.size());
  EXPECT_TRUE(std::filesystem::exists(server().scratch() / ("exported/" + urdf.files[0].name)));
}

TEST_F(Worlds, AreListedAndDeletedByTheirServer) {
  world_.Put("ball", Sphere{0.1});
  const Server on = world_.server();
  EXPECT_FALSE(on.Info().version.empty());
  EXPECT_GT(on.Info().max_batch_rows, 0);
  const auto infos = on.Worlds();
  const auto mine = std::find_if(infos.begin(), infos.end(),
                                 [&](const WorldInfo& info) { return info.name == world_.name(); });
  ASSERT_NE(mine, infos.end());
  EXPECT_EQ(mine->object_count, 1);
  EXPECT_EQ(mine->uid, world_.uid());
  on.DeleteWorld(world_.name());
  EXPECT_EQ(ErrorOf([&] { world_.Objects(); }).reason(), "WORLD_UNKNOWN");
}

TEST_F(Worlds, SayWhatFailed) {
  const Error nowhere = ErrorOf([&] { cwm::Connect({.address = "unix:/nowhere/cwm.sock"}); });
  EXPECT_EQ(nowhere.code(), ErrorCode::kUnavailable);
  EXPECT_THAT(nowhere.what(), HasSubstr("no cwm-server answers at unix:/nowhere/cwm.sock"));

  world_.Put("ball", Sphere{0.1});
  const Error unknown = ErrorOf([&] { world_.Get("bal"); });
  EXPECT_EQ(unknown.code(), ErrorCode::kNotFound);
  EXPECT_EQ(unknown.reason(), "OBJECT_UNKNOWN");
  EXPECT_THAT(unknown.what(), HasSubstr("OBJECT_UNKNOWN"));

  Eigen::Isometry3d nan = At(0, 0, 0);
  nan.translation().x() = std::nan("");
  EXPECT_EQ(ErrorOf([&] { world_.Move("ball", nan); }).fields()[0].field, "changes[0].X_WO");
  EXPECT_EQ(ErrorOf([&] { world_.Within(0); }).fields()[0].field, "timeout_s");
  EXPECT_EQ(ErrorOf([&] { world_.Watch({.from_revision = 3}); }).fields()[0].field,
            "options.world_uid");
  EXPECT_THAT(ErrorOf([&] { world_.LoadRobot({.urdf = "no/such.urdf"}); }).what(),
              HasSubstr("no/such.urdf"));
}

TEST_F(Worlds, EndCallsAtATimeout) {
  RunningServer other;
  const World world = cwm::Connect({.address = other.address(), .world = "slow"});
  world.Put("ball", Sphere{0.1});
  const WorldView hasty = world.Within(0.1);
  other.Pause();
  EXPECT_EQ(ErrorOf([&] { hasty.Objects(); }).code(), ErrorCode::kDeadlineExceeded);
  other.Resume();
  EXPECT_EQ(hasty.Within(std::nullopt).Objects().size(), 1U);
}

TEST_F(Worlds, AnswerAgainAfterARestartOfTheServer) {
  RunningServer other;
  const World world = cwm::Connect({.address = other.address(), .world = "restarted"});
  world.Put("ball", Sphere{0.1});
  const std::string uid = world.uid();
  const WorldView pinned = world.At();
  other.Stop();
  other.Start();
  EXPECT_EQ(world.Put("cube", Box{1, 1, 1}), 1) << "a write is sent once more";
  EXPECT_NE(world.uid(), uid);
  EXPECT_EQ(ErrorOf([&] { pinned.Check(Sphere{0.1}); }).reason(), "WORLD_REPLACED");
}

// Ingesting a scan that is computed here: a table plane seen from above, with a ball on it.
TEST_F(Worlds, ShowAScan) {
  constexpr int kWidth = 160, kHeight = 120;
  constexpr double kFocal_px = 140, kEye_m = 1.0, kRadius_m = 0.12;
  Eigen::Matrix3Xf points(3, kWidth * kHeight);
  Eigen::Index on_ball = 0;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const Eigen::Vector3d ray((u - kWidth / 2.0) / kFocal_px, (v - kHeight / 2.0) / kFocal_px, 1);
      // In the optical frame the ball's centre is below the lens, above the table at z = kEye_m.
      const Eigen::Vector3d centre(0, 0, kEye_m - kRadius_m);
      const double a = ray.squaredNorm(), b = ray.dot(centre);
      const double root = b * b - a * (centre.squaredNorm() - kRadius_m * kRadius_m);
      const double t = root > 0 ? (b - std::sqrt(root)) / a : kEye_m;
      on_ball += root > 0 ? 1 : 0;
      points.col(v * kWidth + u) = (t * ray).cast<float>();
    }
  }
  Eigen::Isometry3d X_WS = At(0, 0, kEye_m);
  X_WS.linear() = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const IngestResult scan =
      world_.Ingest(points, {.X_WS = X_WS, .sensor = SensorNoise{.a_m = 0.001}, .height = kHeight});
  EXPECT_EQ(scan.report.points_in, points.cols());
  EXPECT_EQ(scan.world_uid, world_.uid());
  ASSERT_EQ(scan.supports.size(), 1U);
  ASSERT_EQ(scan.objects.size(), 1U);
  ASSERT_EQ(scan.labels.size(), static_cast<std::size_t>(points.cols()));
  const auto ball = static_cast<double>(scan.PointsOf(scan.objects[0].name).size());
  EXPECT_NEAR(ball, static_cast<double>(on_ball), 0.1 * static_cast<double>(on_ball));
  ASSERT_TRUE(std::holds_alternative<Sphere>(scan.objects[0].parts[0].shape));
  EXPECT_NEAR(std::get<Sphere>(scan.objects[0].parts[0].shape).radius_m, kRadius_m, 0.002);
  EXPECT_TRUE(scan.objects[0].parts[0].fit.has_value());
  EXPECT_EQ(scan.changes.added.size(), 2U);
  EXPECT_EQ(ErrorOf([&] { scan.PointsOf("cup"); }).code(), ErrorCode::kNotFound);

  EXPECT_FALSE(scan.report.unchanged_view);
  const IngestResult again =
      world_.Ingest(points, {.X_WS = X_WS, .sensor = SensorNoise{.a_m = 0.001}, .height = kHeight});
  EXPECT_TRUE(again.report.unchanged_view);
  EXPECT_EQ(again.labels, scan.labels);
  const IngestResult segmented = world_.Ingest(
      points, {.X_WS = X_WS, .height = kHeight, .mode = IngestMode::kSegmentOnly, .labels = false});
  EXPECT_TRUE(segmented.labels.empty());
  EXPECT_EQ(world_.revision(), scan.revision) << "the world stays as it is";
  EXPECT_EQ(ErrorOf([&] { world_.Ingest(points, {.height = 7}); }).fields()[0].field,
            "options.height");
}

}  // namespace
}  // namespace cwm::testing
