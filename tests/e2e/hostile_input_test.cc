// After any input the server reports the error, stays up, keeps its revision, and answers the next
// valid request.
#include <cstring>
#include <fstream>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

constexpr int kBadInput = 8;  // exit codes, see `cwm --help`
constexpr int kNotFound = 3;
constexpr int kConflict = 4;
constexpr int kUsage = 1;

// The header of a binary PCD with x y z floats, whose fields tests can falsify.
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

  // Records the world before the test, and checks afterwards that it is unchanged and that a valid
  // request is answered.
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
    const ProcessResult run = Cwm(arguments, input);
    EXPECT_EQ(run.exit_code, exit_code) << run.out << run.err;
    for (const std::string& words : said) {
      EXPECT_NE(run.err.find(words), std::string::npos) << "'" << words << "' not in: " << run.err;
    }
  }

 private:
  std::int64_t revision_ = 0;
};

// Each message names the file, the field, its value and the violated rule.
TEST_F(HostileInput, LyingCloudFilesAreRefusedByFieldValueAndRule) {
  const std::string one_point = Bytes({0, 0, 1});
  struct Case {
    const char* name;
    std::function<void(PcdHeader&)> lie;
    const char* said;
  };
  const Case cases[] = {
      {"more points than data", [](PcdHeader& h) { h.width = h.points = "1000000"; },
       "POINTS is 1000000, must be what the data holds: at 12 bytes a point there are not enough "
       "in 12 bytes"},
      {"fewer points than data", [](PcdHeader& h) { h.width = h.points = "0"; },
       "POINTS is 0, must be what the data holds: there is more data after the last point"},
      {"negative size", [](PcdHeader& h) { h.sizes = "4 -4 4"; },
       "TYPE and SIZE of field y is F -4, must be"},
      {"size that no number has", [](PcdHeader& h) { h.sizes = "4 3 4"; },
       "TYPE and SIZE of field y is F 3, must be"},
      {"unknown type", [](PcdHeader& h) { h.types = "F Q F"; },
       "TYPE and SIZE of field y is Q 4, must be I or U with 1, 2, 4 or 8, or F with 4 or 8"},
      {"too few types", [](PcdHeader& h) { h.types = "F F"; },
       "number of TYPE entries is 2, must be that of FIELDS, 3"},
      {"count of nothing", [](PcdHeader& h) { h.counts = "1 0 1"; },
       "COUNT of field y is 0, must be an integer from 1 to 65536"},
      {"negative count", [](PcdHeader& h) { h.counts = "1 -1 1"; },
       "COUNT of field y is -1, must be an integer from 1 to 65536"},
      {"count beyond all memory", [](PcdHeader& h) { h.counts = "1 999999999999 1"; },
       "COUNT of field y is 999999999999, must be an integer from 1 to 65536"},
      {"width times height differs", [](PcdHeader& h) { h.height = "7"; },
       "POINTS is 1, must be WIDTH x HEIGHT, 7"},
      {"negative width", [](PcdHeader& h) { h.width = "-1"; },
       "WIDTH is -1, must be an integer from 0 to 2147483647"},
      {"negative points", [](PcdHeader& h) { h.points = "-1"; },
       "POINTS is -1, must be an integer"},
      {"width that is no number", [](PcdHeader& h) { h.width = "nan"; },
       "WIDTH is nan, must be an integer"},
      {"product that overflows",
       [](PcdHeader& h) {
         h.width = h.height = "4294967296";
         h.points = "0";
       },
       "WIDTH is 4294967296, must be an integer from 0 to 2147483647"},
      {"no z", [](PcdHeader& h) { h.fields = "x y w"; }, "field z is missing from the cloud"},
      {"unknown data", [](PcdHeader& h) { h.data = "morse"; },
       "DATA is morse, must be ascii, binary or binary_compressed"},
      {"wrong magic", [](PcdHeader& h) { h.magic = "GIF89a\n"; },
       "must be that of a PCD (\"# .PCD\"), PLY (\"ply\") or NPY (\"\\x93NUMPY\") file, or begin "
       "with three numbers (XYZ)"},
  };
  for (const Case& test : cases) {
    SCOPED_TRACE(test.name);
    PcdHeader header;
    test.lie(header);
    ExpectRefused({"ingest", Write("lie.pcd", header.Text() + one_point)}, kBadInput,
                  {"lie.pcd: ", test.said});
  }
  ExpectRefused({"ingest", scratch() / "absent.pcd"}, kBadInput, {"absent.pcd"});
}

TEST_F(HostileInput, FilesCutShortAreRefusedWhereverTheyEnd) {
  const std::string header = PcdHeader().Text();
  ExpectRefused({"ingest", Write("empty.pcd", "")}, kBadInput, {"empty.pcd: first line must be"});
  ExpectRefused({"ingest", Write("head.pcd", header.substr(0, header.find("DATA")))}, kBadInput,
                {"head.pcd: DATA is missing"});
  ExpectRefused({"ingest", Write("data.pcd", header + "abc")}, kBadInput,
                {"data.pcd: POINTS is 1, must be what the data holds", "3 bytes of data"});
  PcdHeader ascii;
  ascii.data = "ascii";
  ExpectRefused({"ingest", Write("ascii.pcd", ascii.Text() + "0.25 0.25\n")}, kBadInput,
                {"ascii.pcd: number of values of point 0 is 2, must be 3"});
  ExpectRefused(
      {"ingest", Write("words.pcd", ascii.Text() + "0 0\n")}, kBadInput,
      {"words.pcd: POINTS is 1, must be what the data holds: at 3 values a point there are "
       "not enough in 4 bytes of text"});
  PcdHeader packed;
  packed.data = "binary_compressed";
  const std::string sizes("\x09\0\0\0\x0c\0\0\0", 8);  // claims to unpack 9 bytes to 12
  ExpectRefused({"ingest", Write("packed.pcd", packed.Text() + sizes + "abc")}, kBadInput,
                {"packed.pcd: compressed size is 9, must be what the file holds"});
}

TEST_F(HostileInput, LyingPlyFilesAreRefusedByFieldValueAndRule) {
  const auto ply = [](const std::string& count, const std::string& type) {
    return "ply\nformat binary_little_endian 1.0\nelement vertex " + count + "\nproperty " + type +
           " x\nproperty float y\nproperty float z\nend_header\n" + Bytes({0, 0, 1});
  };
  ExpectRefused({"ingest", Write("negative.ply", ply("-5", "float"))}, kBadInput,
                {"negative.ply: count of element vertex is -5, must be an integer of at least 0"});
  ExpectRefused({"ingest", Write("more.ply", ply("99999999", "float"))}, kBadInput,
                {"more.ply: count of element vertex is 99999999, must be what the data holds"});
  ExpectRefused({"ingest", Write("type.ply", ply("1", "quark"))}, kBadInput,
                {"type.ply: type of property x is quark, must be"});
}

TEST_F(HostileInput, CloudsWithoutAnyMeaningAreRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  ExpectRefused({"ingest", Write("none.pcd", HeaderOf(0).Text())}, kBadInput,
                {"point_count: is 0, must be from 1 to"});
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
