// Whatever is sent, the server says what is wrong, stays up, keeps its revision, and the next good
// request works.
#include <cstring>
#include <fstream>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

constexpr int kBadInput = 8;  // exit codes of api: see `cwm --help`
constexpr int kNotFound = 3;
constexpr int kConflict = 4;
constexpr int kUsage = 1;

// The header of a binary PCD of x y z floats, with fields that a test can make lie.
struct PcdHeader {
  std::string magic = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n";
  std::string fields = "x y z";
  std::string sizes = "4 4 4";
  std::string types = "F F F";
  std::string counts = "1 1 1";
  std::string width = "1";
  std::string height = "1";
  std::string points = "1";
  std::string data = "binary";

  std::string Text() const {
    return magic + "FIELDS " + fields + "\nSIZE " + sizes + "\nTYPE " + types + "\nCOUNT " +
           counts + "\nWIDTH " + width + "\nHEIGHT " + height +
           "\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + points + "\nDATA " + data + "\n";
  }
};

std::string Bytes(const std::vector<float>& values) {
  std::string bytes(values.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

PcdHeader HeaderOf(std::size_t points) {
  PcdHeader header;
  header.width = header.points = std::to_string(points);
  return header;
}

class HostileInput : public ServerTest {
 protected:
  std::string Write(const std::string& name, const std::string& content) const {
    std::ofstream(scratch() / name, std::ios::binary) << content;
    return scratch() / name;
  }

  // The world before, and that it is the same after, with a good request answered.
  void SetUp() override {
    ServerTest::SetUp();
    ASSERT_EQ(Cwm({"put", "post", "--cylinder", "0.05,1", "--at", "0,0,0.5"}).exit_code, 0);
    revision_ = RevisionOf("default");
  }
  void TearDown() override {
    EXPECT_EQ(RevisionOf("default"), revision_) << "bad input changed the world";
    EXPECT_EQ(Cwm({"distance", "--sphere", "0.1", "--at", "1,0,0.5"}).exit_code, 0);
    ServerTest::TearDown();
  }

  void ExpectRefused(const std::vector<std::string>& arguments, int exit_code,
                     const std::vector<std::string>& said, const std::string& input = "") {
    const Finished run = Cwm(arguments, input);
    EXPECT_EQ(run.exit_code, exit_code) << run.out << run.err;
    for (const std::string& words : said) {
      EXPECT_NE(run.err.find(words), std::string::npos) << "'" << words << "' not in: " << run.err;
    }
  }

 private:
  std::int64_t revision_ = 0;
};

TEST_F(HostileInput, LyingCloudFilesAreRefusedByName) {
  const std::string one_point = Bytes({0, 0, 1});
  struct Case {
    const char* name;
    std::function<void(PcdHeader&)> lie;
    const char* said;
  };
  const Case cases[] = {
      {"more points than data", [](PcdHeader& h) { h.width = h.points = "1000000"; }, "POINTS"},
      {"negative size", [](PcdHeader& h) { h.sizes = "4 -4 4"; }, "SIZE"},
      {"unknown type", [](PcdHeader& h) { h.types = "F Q F"; }, "TYPE"},
      {"width times height differs", [](PcdHeader& h) { h.height = "7"; }, "POINTS"},
      {"negative width", [](PcdHeader& h) { h.width = "-1"; }, "WIDTH"},
      {"product that overflows",
       [](PcdHeader& h) {
         h.width = h.height = "4294967296";
         h.points = "0";
       },
       "WIDTH"},
      {"no z", [](PcdHeader& h) { h.fields = "x y w"; }, "z"},
      {"unknown data", [](PcdHeader& h) { h.data = "morse"; }, "DATA"},
      {"wrong magic", [](PcdHeader& h) { h.magic = "GIF89a\n"; }, "PCD"},
  };
  for (const Case& test : cases) {
    SCOPED_TRACE(test.name);
    PcdHeader header;
    test.lie(header);
    ExpectRefused({"ingest", Write("lie.pcd", header.Text() + one_point)}, kBadInput,
                  {"lie.pcd", test.said});
  }
  ExpectRefused({"ingest", Write("short.pcd", PcdHeader().Text() + "abc")}, kBadInput,
                {"short.pcd"});
  ExpectRefused({"ingest", Write("empty.pcd", "")}, kBadInput, {"empty.pcd"});
  ExpectRefused({"ingest", scratch() / "absent.pcd"}, kBadInput, {"absent.pcd"});
}

TEST_F(HostileInput, CloudsWithoutAnyMeaningAreRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  ExpectRefused({"ingest", Write("none.pcd", HeaderOf(0).Text())}, kBadInput, {"point"});
  ExpectRefused(
      {"ingest", Write("nan.pcd", HeaderOf(2).Text() + Bytes({nan, nan, nan, nan, nan, nan}))},
      kBadInput, {"finite"});
  ExpectRefused({"ingest", Write("far.pcd", HeaderOf(1).Text() + Bytes({1e30F, 0, 1}))}, kBadInput,
                {"1e+30"});
}

TEST_F(HostileInput, DegenerateCloudsAreTakenInAWorldOfTheirOwn) {
  std::vector<float> equal;
  for (int i = 0; i < 1000; ++i) equal.insert(equal.end(), {0.1F, 0.2F, 0.9F});
  for (const auto& [name, values] :
       {std::pair<std::string, std::vector<float>>{"one", {0.1F, 0.2F, 0.9F}}, {"equal", equal}}) {
    const nlohmann::json answer =
        CwmJson({"ingest", Write(name + ".pcd", HeaderOf(values.size() / 3).Text() + Bytes(values)),
                 "--world", name});
    ASSERT_TRUE(answer.is_object());
    EXPECT_EQ(answer.at("report").at("points_finite"), std::to_string(values.size() / 3));
    EXPECT_TRUE(answer.at("supports").empty());
    EXPECT_FALSE(answer.at("report").at("warnings").empty())
        << "a scene without support is worth a word";
  }
}

TEST_F(HostileInput, ImpossibleShapesAreRefusedByField) {
  ExpectRefused({"put", "bad", "--sphere", "0"}, kBadInput, {"radius_m", "0", "positive"});
  ExpectRefused({"put", "bad", "--sphere", "-1"}, kBadInput, {"radius_m", "-1"});
  ExpectRefused({"put", "bad", "--box", "0.1,nan,0.1"}, kBadInput, {"size_y_m", "nan"});
  ExpectRefused({"put", "bad", "--sphere", "0.1", "--at", "0,0,nan"}, kBadInput, {"tz_m", "nan"});
  ExpectRefused({"put", "bad", "--sphere", "0.1", "--at", "0,0,0,0,0,0,0.5"}, kBadInput,
                {"0.5", "1"});
  ExpectRefused({"put", "a/../b\n", "--sphere", "0.1"}, kBadInput, {"name"});
}

TEST_F(HostileInput, WhatIsUnknownIsNamed) {
  ExpectRefused({"objects", "--world", "atlantis"}, kNotFound, {"atlantis"});
  ExpectRefused({"get", "unicorn"}, kNotFound, {"unicorn"});
  ExpectRefused({"move", "unicorn", "--at", "0,0,0"}, kNotFound, {"unicorn"});
  ExpectRefused({"remove", "unicorn"}, kNotFound, {"unicorn"});
  ExpectRefused({"distance", "--object", "unicorn"}, kNotFound, {"unicorn"});
  ExpectRefused({"distance", "--sphere", "0.1", "--at", "0,0,0", "--engine", "warp"}, kUsage,
                {"warp"});
  ExpectRefused({"distance", "--sphere", "0.1", "--at", "0,0,0", "--at-revision", "999"}, kConflict,
                {"999"});
  ExpectRefused({"frobnicate"}, kUsage, {"frobnicate"});
}

TEST_F(HostileInput, OneBadPoseAmong4095GoodOnesRefusesTheBatchAndNamesTheRow) {
  std::string lines;
  for (int i = 0; i < 4096; ++i) {
    lines += i == 2718 ? "{\"at\": [0, 0, 0, 0, 0, 0, 0.25]}\n" : "{\"at\": [0.5, 0, 0]}\n";
  }
  ExpectRefused({"distance", "--sphere", "0.1"}, kBadInput, {"2718"}, lines);
}

TEST_F(HostileInput, MeshesWithBadIndicesOrNoTrianglesAreRefused) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\n";
  const std::string vertices = "0 0 0\n1 0 0\n0 1 0\n";
  ExpectRefused(
      {"put", "bad", "--mesh",
       Write("index.ply",
             head + "element face 1\nproperty list uchar int vertex_indices\nend_header\n" +
                 vertices + "3 0 1 7\n")},
      kBadInput, {"7"});
  ExpectRefused(
      {"put", "bad", "--mesh",
       Write("none.ply",
             head + "element face 0\nproperty list uchar int vertex_indices\nend_header\n" +
                 vertices)},
      kBadInput, {"triangle"});
}

}  // namespace
}  // namespace cwm::testing
