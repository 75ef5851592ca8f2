// The labelled cloud of `cwm segment`, compared byte by byte with the scheme: 0 is unexplained; 1
// to 9 are the supports (the tenth and later share 9); object i (from 1) has 10 (i + 1) + part,
// where part 0 is the object itself and 1 to 9 are its parts.
#include <cmath>
#include <cstring>
#include <map>

#include "clients/formats/cloud_reader.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/pcd.h"
#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using formats::CloudFile;
using nlohmann::json;

constexpr std::uint32_t kLastSupportLabel = 9;
constexpr std::uint32_t kLabelsPerObject = 10;

class SegmentLabels : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    cloud_ = Simulate("kitchen", {"--scene", "kitchen", "--seed", "1"});
    labelled_ = scratch() / "labelled.pcd";
    answer_ = CwmJson({"segment", cloud_, labelled_});
    ASSERT_TRUE(answer_.is_object());
  }

  static CloudFile Read(const std::string& path) {
    auto cloud = formats::ReadCloud(path);
    EXPECT_TRUE(cloud.ok()) << cloud.status();
    return cloud.ok() ? *std::move(cloud) : CloudFile();
  }
  static std::vector<std::uint32_t> LabelsOf(const CloudFile& cloud) {
    const CloudFile only = formats::SelectFields(cloud, {"label"});
    std::vector<std::uint32_t> labels(static_cast<std::size_t>(cloud.size()));
    EXPECT_EQ(only.bytes.size(), labels.size() * sizeof(labels[0]));
    std::memcpy(labels.data(), only.bytes.data(), only.bytes.size());
    return labels;
  }
  static std::string Bytes(const std::string& path) {
    auto bytes = formats::ReadFileBytes(path);
    EXPECT_TRUE(bytes.ok()) << bytes.status();
    return bytes.ok() ? *bytes : "";
  }
  static std::int64_t Number(const json& object, const char* key) {
    return std::stoll(object.at(key).get<std::string>());
  }

  std::string cloud_, labelled_;
  json answer_;
};

TEST_F(SegmentLabels, AreAddedToTheSamePointsInTheSameOrder) {
  const CloudFile in = Read(cloud_);
  const CloudFile out = Read(labelled_);
  EXPECT_EQ(out.width, in.width);
  EXPECT_EQ(out.height, in.height);
  ASSERT_EQ(out.fields.size(), in.fields.size() + 1);
  EXPECT_EQ(out.fields.back().name, "label");
  EXPECT_EQ(out.fields.back().type, formats::Scalar::kU32);
  EXPECT_EQ(formats::SelectFields(out, {"x", "y", "z"}).bytes,
            formats::SelectFields(in, {"x", "y", "z"}).bytes);
}

TEST_F(SegmentLabels, CountThePointsOfWhatTheAnswerNames) {
  const CloudFile in = formats::SelectFields(Read(cloud_), {"x", "y", "z"});
  const std::vector<std::uint32_t> labels = LabelsOf(Read(labelled_));
  const json& supports = answer_.at("supports");
  const json& objects = answer_.at("objects");
  std::map<std::uint32_t, std::int64_t> of_support, of_object;
  std::int64_t unlabelled = 0;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    float p[3];
    std::memcpy(p, &in.bytes[i * in.point_step], sizeof(p));
    if (!std::isfinite(p[0])) {
      ASSERT_EQ(labels[i], 0U) << "point " << i << " was not measured";
    }
    if (labels[i] == 0) {
      ++unlabelled;
    } else if (labels[i] <= kLastSupportLabel) {
      ++of_support[labels[i]];
    } else {
      const std::uint32_t object = labels[i] / kLabelsPerObject - 2;
      ASSERT_LT(object, objects.size()) << "label " << labels[i];
      const json& named = objects.at(object);
      ASSERT_LE(
          labels[i] % kLabelsPerObject,
          named.at("shapes").size() + named.at("surfaces").size() + named.at("handles").size())
          << "label " << labels[i] << " of " << named.at("name");
      ++of_object[object];
    }
  }
  ASSERT_EQ(of_support.size(), supports.size());
  for (std::uint32_t i = 0; i < supports.size(); ++i) {
    EXPECT_EQ(of_support[i + 1], Number(supports[i], "point_count")) << supports[i].at("name");
  }
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    EXPECT_EQ(of_object[i], Number(objects[i], "point_count")) << objects[i].at("name");
  }
  // A measured point belongs to an object or a support, or is counted as rejected.
  const json& report = answer_.at("report");
  EXPECT_EQ(unlabelled, Number(report, "points_in") - Number(report, "points_finite") +
                            Number(report, "points_rejected"));
}

TEST_F(SegmentLabels, AreTheSameBytesWhoeverAsksAndHoweverOften) {
  const std::string first = Bytes(labelled_);
  // An ingest into an empty world gives the same labels as segmenting.
  ASSERT_EQ(Cwm({"ingest", cloud_, "--labels", scratch() / "ingested.pcd"}).exit_code, 0);
  EXPECT_EQ(Bytes(scratch() / "ingested.pcd"), first);
  // A label field in the input is ignored and replaced.
  ASSERT_EQ(Cwm({"segment", labelled_, scratch() / "again.pcd"}).exit_code, 0);
  EXPECT_EQ(Bytes(scratch() / "again.pcd"), first);
}

TEST_F(SegmentLabels, ComeWithAReportInEveryForm) {
  const ProcessResult table = Cwm({"segment", cloud_, labelled_});
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_EQ(table.err, "") << "progress is for terminals";
  for (const char* words : {"307200 points, ", " explained (", "LABEL", "support_1", "object_1",
                            "coefficients: ", "stages (ms): "}) {
    EXPECT_NE(table.out.find(words), std::string::npos) << words << " not in:\n" << table.out;
  }
  const ProcessResult line = Cwm({"-o", "ndjson", "ingest", cloud_});
  EXPECT_EQ(line.exit_code, 0) << line.err;
  const json ingested = json::parse(line.out);
  EXPECT_EQ(ingested.at("report"), answer_.at("report"));
  EXPECT_EQ(ingested.at("revision"), "1");
  EXPECT_EQ(ingested.at("changes").at("added").size(),
            answer_.at("supports").size() + answer_.at("objects").size());
}

TEST_F(SegmentLabels, TellThatAFilesViewpointIsNoPoseUnlessOneIsGiven) {
  CloudFile moved = Read(cloud_);
  moved.viewpoint = {0.5, 0, 1.25, 0, 1, 0, 0};
  const auto bytes = formats::FormatPcd(moved, formats::PcdData::kBinary);
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  const std::string path = scratch() / "moved.pcd";
  ASSERT_TRUE(formats::WriteFileBytes(path, *bytes).ok());
  const std::string advice = "--x-world-sensor 0.5,0,1.25,1,0,0,0";
  EXPECT_NE(Cwm({"segment", path, labelled_}).err.find(advice), std::string::npos);
  EXPECT_EQ(Cwm({"segment", path, labelled_, "--x-world-sensor", "0,0,1,1,0,0,0"}).err, "");
}

}  // namespace
}  // namespace cwm::testing
