#include "clients/formats/xyz.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/clients/formats/invalid_file.h"

namespace cwm::formats {
namespace {

using ::testing::HasSubstr;

double At(const CloudFile& cloud, std::size_t point, const std::string& field) {
  const CloudField& f = *cloud.Find(field);
  return ToDouble(&cloud.bytes[point * cloud.point_step + f.offset], f.type);
}

TEST(Xyz, ReadsThreeNumbersALineBetweenAnythingThatSeparates) {
  for (const char* text :
       {"0.1 -2 3e-2\n4 5 6\n", "0.1,-2,3e-2\r\n4,5,6\r\n", "0.1;-2 ; 3e-2\n4;5;6",
        "\n# a scan\n  0.1\t-2  3e-2 255 0 17\n\n// more\n4 5 6 1\n",
        "0.1, -2, 3e-2,\n4, 5, 6,\n"}) {
    EXPECT_TRUE(LooksLikeXyz(text)) << text;
    const auto cloud = ParseXyz(text, "a.xyz");
    ASSERT_TRUE(cloud.ok()) << text << cloud.status();
    ASSERT_EQ(cloud->size(), 2) << text;
    EXPECT_EQ(cloud->fields.size(), 3U);
    EXPECT_EQ(At(*cloud, 0, "x"), 0.1);
    EXPECT_EQ(At(*cloud, 0, "y"), -2);
    EXPECT_EQ(At(*cloud, 0, "z"), 0.03);
    EXPECT_EQ(At(*cloud, 1, "z"), 6);
  }
}

TEST(Xyz, TakesTheColumnsThatAHeaderNames) {
  for (const char* text : {"# z y x nx ny nz\n3 2 1 0 0 1\n", "//Z Y X Nx Ny Nz\n3 2 1 0 0 1\n",
                           "# made by hand\n\"z\",\"y\",\"x\",nx,ny,nz\n3,2,1,0,0,1\n"}) {
    EXPECT_TRUE(LooksLikeXyz(text)) << text;
    const auto cloud = ParseXyz(text, "a.csv");
    ASSERT_TRUE(cloud.ok()) << text << cloud.status();
    EXPECT_EQ(At(*cloud, 0, "x"), 1);
    EXPECT_EQ(At(*cloud, 0, "z"), 3);
    EXPECT_EQ(At(*cloud, 0, "normal_z"), 1);
  }
}

TEST(Xyz, KeepsPointsThatWereNotMeasured) {
  for (const char* text : {"nan nan nan\n1 2 3\n", "1.#QNAN -1.#IND 1.#QNAN0\n1 2 3\n"}) {
    const auto cloud = ParseXyz(text, "a.xyz");
    ASSERT_TRUE(cloud.ok()) << cloud.status();
    EXPECT_TRUE(std::isnan(At(*cloud, 0, "y")));
    EXPECT_EQ(cloud->size(), 2);
  }
  const auto infinite = ParseXyz("1.#INF -1.#INF00 0\n", "a.xyz");
  ASSERT_TRUE(infinite.ok()) << infinite.status();
  EXPECT_EQ(At(*infinite, 0, "x"), INFINITY);
  EXPECT_EQ(At(*infinite, 0, "y"), -INFINITY);
}

// As Leica's PTS and CloudCompare's ASC write it; a PTS may hold several scans.
TEST(Xyz, ChecksTheCountThatAFileBeginsWith) {
  for (const char* text :
       {"2\n1 2 3\n4 5 6\n", "//X Y Z\n2\n1 2 3\n4 5 6\n", "1\n1 2 3 -900\n1\n4 5 6 -900\n"}) {
    EXPECT_TRUE(LooksLikeXyz(text)) << text;
    const auto cloud = ParseXyz(text, "a.pts");
    ASSERT_TRUE(cloud.ok()) << text << cloud.status();
    ASSERT_EQ(cloud->size(), 2) << text;
    EXPECT_EQ(At(*cloud, 1, "z"), 6);
  }
}

TEST(Xyz, TakesAColumnWithoutANameForAnIndex) {
  const auto cloud = ParseXyz(",x,y,z\n0,1,2,3\n1,4,5,6\n", "pandas.csv");
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  ASSERT_EQ(cloud->size(), 2);
  EXPECT_EQ(At(*cloud, 1, "x"), 4);
}

TEST(Xyz, DoesNotTakeOtherTextForPoints) {
  for (const char* text :
       {"", "hello\n", "v 0 0 0\n", "solid a\n", "(scene)+\n* cup\n", "name: scene\n", "1 2\n",
        "# x y z\n", "x,y,intensity\n1,2,3\n", "{\"x\": 1}", "glTF"}) {
    EXPECT_FALSE(LooksLikeXyz(text)) << text;
  }
}

class HostileXyz : public ::testing::TestWithParam<InvalidFile> {};

TEST_P(HostileXyz, IsRefusedNamingFileLineValueAndRule) {
  ExpectRefusal(ParseXyz(GetParam().text, "hostile.xyz").status(), "hostile.xyz", GetParam());
}

INSTANTIATE_TEST_SUITE_P(
    InvalidFiles, HostileXyz,
    ::testing::Values(
        InvalidFile{"Empty", "", "the file", "at least one line with a point"},
        InvalidFile{"CommentsAlone", "# x y z\n\n", "the file", "at least one line with a point"},
        InvalidFile{"TooFewNumbers", "1 2 3\n4 5\n", "line 2 number of columns is 2", "at least 3"},
        InvalidFile{"FewerThanTheHeaderNames", "x y z i\n1 2 3\n", "line 2 number of columns is 3",
                    "must be 4, as the header names them"},
        InvalidFile{"MoreThanTheHeaderNames", "x,y,z\n1,2,3,4\n", "line 2 number of columns is 4",
                    "must be 3"},
        InvalidFile{"AWord", "1 2 3\n1 two 3\n", "line 2 y is \"two\"", "must be a number"},
        InvalidFile{"ADecimalComma", "1,5 2,5 3,5\n", "line 1 y is \"5 2\"", "a decimal point"},
        InvalidFile{"AMissingValue", "1,2,3\n1,,3\n", "line 2 y is \"\"", "must be a number"},
        InvalidFile{"AHeaderLater", "1 2 3\nx y z\n", "line 2 x is \"x\"", "must be a number"},
        InvalidFile{"ZeroByte", "1 2 3\n\x01 2 3\n", "line 2 x is \"?\"", "must be a number"},
        InvalidFile{"TooLarge", "1e999 2 3\n", "line 1 x is \"1e999\"", "must be a number"},
        InvalidFile{"FewerPointsThanCounted", "3\n1 2 3\n4 5 6\n", "number of points is 2",
                    "must be 3, as the file counts them"},
        InvalidFile{"MorePointsThanCounted", "1\n1 2 3\n4 5 6\n", "number of points is 2",
                    "must be 1"},
        InvalidFile{"AColumnTwice", "x y z x\n1 2 3 4\n", "line 2 column is x",
                    "must not be named twice"}),
    [](const ::testing::TestParamInfo<InvalidFile>& info) { return std::string(info.param.name); });

TEST(Xyz, RefusesMoreColumnsThanAPointCanHave) {
  std::string header = "x y z", row = "1 2 3";
  for (int i = 0; i < 300; ++i) {
    header += " c" + std::to_string(i);
    row += " 0";
  }
  const auto cloud = ParseXyz(header + "\n" + row + "\n", "wide.xyz");
  EXPECT_THAT(std::string(cloud.status().message()),
              HasSubstr("number of columns is more than 256, must be at most 256"));
}

// Surplus columns are skipped without cost, however many there are.
TEST(Xyz, LeavesOutTheRestOfALongLine) {
  std::string row = "1,2,3";
  for (int i = 0; i < 100'000; ++i) row += ",";
  const auto cloud = ParseXyz(row + "\n4,5,6\n", "long.csv");
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->size(), 2);
  EXPECT_EQ(cloud->bytes.size(), 6 * sizeof(double));
}

// A truncated file has fewer points or an error, never another first point.
TEST(Xyz, FailsCleanlyOrReadsLessWhenCutAtAnyByte) {
  const std::string text = "# x y z i\n0.25 1 2 7\n4 5 6 8\n";
  for (std::size_t size = 0; size < text.size(); ++size) {
    const auto cloud = ParseXyz(text.substr(0, size), "cut.xyz");
    if (!cloud.ok()) {
      EXPECT_EQ(cloud.status().code(), absl::StatusCode::kInvalidArgument);
      continue;
    }
    EXPECT_EQ(At(*cloud, 0, "x"), 0.25) << "cut at " << size;
  }
}

}  // namespace
}  // namespace cwm::formats
