// Values written as messages and read again: bit by bit the same.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "collision/world/model_equality.h"
#include "proto/transfer/mesh_bytes.h"
#include "proto/transfer/sha256.h"
#include "server/store/decode_values.h"
#include "server/store/encode_entry.h"
#include "server/store/keep_blobs.h"
#include "server/store/memory_store.h"
#include "tests/server/store/many_shapes.h"
#include "tests/server/store/recorded_world.h"

namespace cwm::server {
namespace {

bool SameBits(const Pose& a, const Pose& b) {
  const auto bits = [](double number) { return std::bit_cast<std::uint64_t>(number); };
  return std::equal(a.matrix().data(), a.matrix().data() + 16, b.matrix().data(),
                    [&](double x, double y) { return bits(x) == bits(y); });
}
bool SameBits(const TriangleMesh& a, const TriangleMesh& b) {
  return EncodeMesh(a) == EncodeMesh(b);
}

MeshContents ContentsOf(const Store& store) {
  return
      [&store](const store::v1::Mesh& mesh) -> absl::StatusOr<std::shared_ptr<const TriangleMesh>> {
        if (!mesh.has_blob()) return DecodeContent(mesh.mesh_f64());
        const auto bytes = store.GetBlob(mesh.blob().sha256());
        if (!bytes.ok()) return bytes.status();
        return DecodeContent(*bytes);
      };
}

std::shared_ptr<const HybridModel> RoundTrip(const std::shared_ptr<const HybridModel>& model) {
  MemoryStore store;
  collision::PreparedModel prepared;
  prepared.model = model;
  const collision::Change put{
      collision::PutObject{.name = {},
                           .geometry = std::make_shared<const collision::PreparedModel>(prepared),
                           .supported_by = {}},
      std::nullopt};
  EXPECT_TRUE(KeepGeometry(store, {{std::get<collision::PutObject>(put.what).geometry}},
                           Durability::kDurable)
                  .ok());
  BlobHashes blobs;
  store::v1::Model read;
  EXPECT_TRUE(read.ParseFromString(EncodeModel(*model, blobs).SerializeAsString()));
  for (const std::string& hash : blobs) EXPECT_TRUE(store.GetBlob(hash).ok()) << hash;
  auto decoded = DecodeModel(read, ContentsOf(store));
  EXPECT_TRUE(decoded.ok()) << decoded.status();
  return *decoded;
}

TEST(RecordValues, AModelOfEveryKindOfPartIsReadBitByBit) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto model = ModelSource(seed).FullModel();
    const auto read = RoundTrip(model);
    ASSERT_TRUE(collision::SameModel(*model, *read));
    // SameModel takes 0 for -0, and no mesh for an empty one.
    for (std::size_t i = 0; i < model->shapes.size(); ++i) {
      EXPECT_TRUE(SameBits(model->shapes[i].X_OS, read->shapes[i].X_OS));
      ASSERT_EQ(model->shapes[i].fit.has_value(), read->shapes[i].fit.has_value());
      if (!model->shapes[i].fit) continue;
      EXPECT_TRUE(std::signbit(read->shapes[i].fit->parameter_sigma[1]));
      EXPECT_EQ(read->shapes[i].fit->max_residual_m, 1e-300);
      EXPECT_TRUE(SameBits(model->shapes[i].hidden->X_FS, read->shapes[i].hidden->X_FS));
    }
    for (std::size_t i = 0; i < model->surfaces.size(); ++i) {
      EXPECT_TRUE(SameBits(*model->surfaces[i].surface.mesh, *read->surfaces[i].surface.mesh));
    }
    EXPECT_EQ(read->handles[0].surface.mesh, nullptr);
    BlobHashes a, b;
    EXPECT_EQ(EncodeModel(*model, a).SerializeAsString(),
              EncodeModel(*read, b).SerializeAsString());
    EXPECT_EQ(a, b);
    EXPECT_FALSE(a.empty()) << "the model has a mesh that is a blob";
  }
}

TEST(RecordValues, OnlyMeshesOf64KibAndMoreAreBlobs) {
  ModelSource source(1);
  EXPECT_FALSE(IsBlob(*source.AnyMesh(1364)));
  EXPECT_TRUE(IsBlob(*source.AnyMesh(1365)));
  const TriangleMesh mesh = *source.AnyMesh(17);
  EXPECT_EQ(EncodedBytes(mesh), static_cast<std::int64_t>(EncodeMesh(mesh).size()));
}

TEST(RecordValues, RulesKeepTheirEndInWallTimeAndGetOneOnTheNewClock) {
  const ClockPair now;
  collision::PairRule rule{.pair = {.a = {.name = "a"}, .b = {.name = "b", .link = "l"}},
                           .allowed = true,
                           .margin_m = 0.25};
  rule.expires =
      collision::Expiry{.due = now.steady, .wall_time = now.wall + std::chrono::hours(1)};
  const auto later = DecodeRule(EncodeRule(rule), now);
  ASSERT_TRUE(later.ok()) << later.status();
  EXPECT_EQ(later->expires->wall_time, rule.expires->wall_time);
  EXPECT_EQ(later->expires->due, now.steady + std::chrono::hours(1));
  EXPECT_EQ(later->margin_m, rule.margin_m);
  rule.expires->wall_time = now.wall - std::chrono::hours(1);
  const auto past = DecodeRule(EncodeRule(rule), now);
  ASSERT_TRUE(past.ok());
  EXPECT_EQ(past->expires->wall_time, rule.expires->wall_time);
  EXPECT_EQ(past->expires->due, now.steady) << "due at once";
}

TEST(RecordValues, PastTimesAreConvertedToTheSteadyClockAndFutureOnesAreNow) {
  const ClockPair now;
  const std::int64_t now_ns = NanosecondsOf(now.wall);
  EXPECT_EQ(SteadyTimeOf(now_ns - 5'000, now), now.steady - std::chrono::nanoseconds(5'000));
  EXPECT_EQ(SteadyTimeOf(now_ns + 5'000, now), now.steady);
  EXPECT_LT(SteadyTimeOf(std::numeric_limits<std::int64_t>::min(), now), now.steady);
  EXPECT_EQ(SteadyTimeOf(std::numeric_limits<std::int64_t>::max(), now), now.steady);
}

TEST(RecordValues, FilesOfARobotAreReadAsTheyWereKept) {
  MemoryStore store;
  RobotFiles files{.urdf = "<robot/>", .srdf = "", .spheres = std::string("\0\xfe", 2)};
  files.meshes = {{"a.stl", "bytes"}, {"b.stl", ""}};
  files.settings.padding_m = {{.link = "*", .value = 0.01}, {.link = "x", .value = -0.0}};
  files.settings.scale = {{.link = "y", .value = 1.25}};
  files.settings.tools = {
      {.name = "t", .link = "l", .X_LT = MakeTranslation(1, 2, 3), .group = "g"}};
  const auto hash = KeepRobotFiles(store, files);
  ASSERT_TRUE(hash.ok()) << hash.status();
  EXPECT_EQ(*KeepRobotFiles(store, files), *hash) << "equal files have one hash";
  const auto read = ReadRobotFiles(store, *hash);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->urdf, files.urdf);
  EXPECT_EQ(read->srdf, files.srdf) << "an empty file is not an absent one";
  EXPECT_EQ(read->spheres, files.spheres);
  EXPECT_EQ(read->meshes, files.meshes);
  EXPECT_EQ(read->files_hash, *hash);
  ASSERT_EQ(read->settings.padding_m.size(), 2u);
  EXPECT_TRUE(std::signbit(read->settings.padding_m[1].value));
  EXPECT_EQ(read->settings.scale[0].value, 1.25);
  EXPECT_EQ(read->settings.tools[0].group, "g");
  EXPECT_TRUE(SameBits(read->settings.tools[0].X_LT, files.settings.tools[0].X_LT));

  files.settings.scale[0].value = 1.5;
  EXPECT_NE(*KeepRobotFiles(store, files), *hash);
}

TEST(RecordValues, ARecordNamesAllBlobsOfItsRobot) {
  MemoryStore store;
  RecordingJournal journal(store);
  const auto world = MakeRecordedWorld("w", "uid", journal);
  const auto arm = KeptArm(journal);
  const collision::Change put{collision::testing::PutArm("arm", arm), std::nullopt};
  ASSERT_TRUE(world->Apply({&put, 1}, {}).ok());
  const auto records = store.Follow("uid", 0, 1 << 20);
  ASSERT_TRUE(records.ok());
  ASSERT_EQ(records->size(), 1u);
  const std::vector<std::string>& blobs = records->front().blobs;
  EXPECT_THAT(blobs, ::testing::IsSupersetOf({arm->files_hash,
                                              Sha256Hex(collision::testing::ArmUrdf("arm", "0.1")),
                                              Sha256Hex(collision::testing::ArmSrdf()),
                                              Sha256Hex(std::string_view("\0\xff\n", 3))}));
}

TEST(RecordValues, AMoveIsWrittenWithoutGeometry) {
  MemoryStore store;
  RecordingJournal journal(store);
  const auto world = MakeRecordedWorld("w", "uid", journal);
  const auto model = ModelSource(3).FullModel();
  const std::vector<collision::Change> put = {
      {collision::PutObject{.name = "a", .geometry = collision::Prepare(model), .supported_by = {}},
       std::nullopt}};
  ASSERT_TRUE(world->Apply(put, {}).ok());
  const collision::Change move{collision::MoveObject{"a", MakeTranslation(1, 2, 3)}, std::nullopt};
  ASSERT_TRUE(world->Apply({&move, 1}, {}).ok());
  const auto records = store.Follow("uid", 0, 1 << 20);
  ASSERT_EQ(records->size(), 2u);
  EXPECT_FALSE((*records)[0].blobs.empty());
  EXPECT_TRUE((*records)[1].blobs.empty());
  EXPECT_LT((*records)[1].payload.size(), 300u);
}

}  // namespace
}  // namespace cwm::server
