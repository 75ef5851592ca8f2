#include "clients/formats/pcd.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "tests/clients/formats/invalid_file.h"

namespace cwm::formats {
namespace {

using ::testing::ElementsAre;
using ::testing::Test;

template <class T>
std::string Bytes(std::initializer_list<T> values) {
  std::string bytes;
  for (const T value : values) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes.append(raw, sizeof(T));
  }
  return bytes;
}

double At(const CloudFile& cloud, std::size_t point, const std::string& field) {
  const CloudField& f = *cloud.Find(field);
  return ToDouble(&cloud.bytes[point * cloud.point_step + f.offset], f.type);
}

std::vector<std::string> Names(const CloudFile& cloud) {
  std::vector<std::string> names;
  for (const CloudField& field : cloud.fields) names.push_back(field.name);
  return names;
}

std::string Header(const std::string& fields, const std::string& extent, const std::string& data) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n" + fields + "\n" + extent +
         "\nVIEWPOINT 0 0 0 1 0 0 0\nDATA " + data + "\n";
}

const char kXyz[] = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1";

// Every scalar type, a vector field and a label, with values that use the types' full range.
CloudFile EveryType() {
  CloudFile cloud;
  const Scalar types[] = {Scalar::kI8,  Scalar::kU8,  Scalar::kI16, Scalar::kU16, Scalar::kI32,
                          Scalar::kU32, Scalar::kI64, Scalar::kU64, Scalar::kF32, Scalar::kF64};
  for (const Scalar type : types) {
    cloud.fields.push_back({.name = std::string(NameOf(type)), .type = type});
  }
  cloud.fields.push_back({.name = "histogram", .type = Scalar::kF32, .count = 33});
  cloud.point_step = AssignOffsets(cloud.fields);
  cloud.width = 7;
  cloud.height = 3;
  cloud.viewpoint = {0.1, -2, 1.0 / 3, 0.5, 0.5, 0.5, 0.5};
  for (std::size_t i = 0; i < cloud.point_step * 21; ++i) {
    cloud.bytes.push_back(static_cast<char>(i * 37 + i / 11));
  }
  return cloud;
}

TEST(Pcd, ReadsAsciiWithAnyOrderTypesPaddingAndVectors) {
  const std::string text = Header(
      "FIELDS label _ z descriptor y x\nSIZE 4 1 4 2 8 4\nTYPE U U F I F F\nCOUNT 1 2 1 3 1 1",
      "WIDTH 2\nHEIGHT 1\nPOINTS 2",
      "ascii\n21 9 9 0.5 -1 0 1 2.25 nan\n\n4294967295 9 9 +1e3 1 2 3 -0 .5");
  const auto cloud = ParsePcd(text, "a.pcd");
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_THAT(Names(*cloud), ElementsAre("label", "z", "descriptor", "y", "x"));
  EXPECT_EQ(cloud->point_step, 4u + 4 + 6 + 8 + 4);
  EXPECT_EQ(At(*cloud, 0, "label"), 21);
  EXPECT_EQ(At(*cloud, 1, "label"), 4294967295.0);
  EXPECT_EQ(At(*cloud, 0, "z"), 0.5);
  EXPECT_EQ(At(*cloud, 1, "z"), 1000);
  EXPECT_EQ(At(*cloud, 0, "descriptor"), -1);
  EXPECT_EQ(At(*cloud, 0, "y"), 2.25);
  EXPECT_TRUE(std::isnan(At(*cloud, 0, "x")));
  EXPECT_EQ(At(*cloud, 1, "x"), 0.5);
}

TEST(Pcd, ReadsBinaryPointByPointAndDropsPadding) {
  const std::string text = Header("FIELDS x _ y z\nSIZE 4 1 4 4\nTYPE F U F F\nCOUNT 1 3 1 1",
                                  "WIDTH 1\nHEIGHT 2\nPOINTS 2", "binary") +
                           Bytes<float>({1}) + "abc" + Bytes<float>({2, 3, 4}) + "def" +
                           Bytes<float>({5, 6});
  const auto cloud = ParsePcd(text, "b.pcd");
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->bytes, Bytes<float>({1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(cloud->width, 1);
  EXPECT_EQ(cloud->height, 2);
}

TEST(Pcd, ReadsCompressedFieldByField) {
  // Two literal runs, made by hand: columns x x y y z z.
  const std::string columns = Bytes<float>({1, 4, 2, 5, 3, 6});
  const std::string packed =
      std::string(1, '\x0f') + columns.substr(0, 16) + std::string(1, '\x07') + columns.substr(16);
  const std::string text = Header(kXyz, "WIDTH 2\nHEIGHT 1\nPOINTS 2", "binary_compressed") +
                           Bytes<std::uint32_t>({static_cast<std::uint32_t>(packed.size()), 24}) +
                           packed;
  const auto cloud = ParsePcd(text, "c.pcd");
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->bytes, Bytes<float>({1, 2, 3, 4, 5, 6}));
}

TEST(Pcd, SurvivesARoundTripInEveryEncoding) {
  const CloudFile cloud = EveryType();
  for (const PcdData data : {PcdData::kBinary, PcdData::kBinaryCompressed}) {
    const auto text = FormatPcd(cloud, data);
    ASSERT_TRUE(text.ok()) << text.status();
    const auto back = ParsePcd(*text, "round.pcd");
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(back->fields, cloud.fields);
    EXPECT_EQ(back->bytes, cloud.bytes);
    EXPECT_EQ(back->viewpoint, cloud.viewpoint);
    EXPECT_EQ(back->width, cloud.width);
    EXPECT_EQ(back->height, cloud.height);
  }
}

TEST(Pcd, HoldsAnEmptyCloud) {
  CloudFile cloud = EveryType();
  cloud.width = 0;
  cloud.bytes.clear();
  const auto back = ParsePcd(*FormatPcd(cloud, PcdData::kBinaryCompressed), "empty.pcd");
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->size(), 0);
}

TEST(Pcd, FailsCleanlyWhenCutAtAnyByte) {
  const CloudFile cloud = EveryType();
  for (const PcdData data : {PcdData::kBinary, PcdData::kBinaryCompressed}) {
    const std::string text = *FormatPcd(cloud, data);
    for (std::size_t size = 0; size < text.size(); ++size) {
      const auto cut = ParsePcd(text.substr(0, size), "cut.pcd");
      ASSERT_EQ(cut.status().code(), absl::StatusCode::kInvalidArgument) << "cut at " << size;
    }
  }
}

TEST(Pcd, NeverCrashesOnAFlippedByte) {
  const std::string text = *FormatPcd(EveryType(), PcdData::kBinaryCompressed);
  for (std::size_t at = 0; at < text.size(); ++at) {
    for (const char flip : {'\x01', '\x10', '\x7f'}) {
      std::string broken = text;
      broken[at] ^= flip;
      const auto cloud = ParsePcd(broken, "flipped.pcd");
      ASSERT_TRUE(cloud.ok() || absl::IsInvalidArgument(cloud.status())) << cloud.status();
    }
  }
}

class HostilePcd : public ::testing::TestWithParam<InvalidFile> {};

TEST_P(HostilePcd, IsRefusedNamingFileFieldAndRule) {
  ExpectRefusal(ParsePcd(GetParam().text, "hostile.pcd").status(), "hostile.pcd", GetParam());
}

std::string Three(const std::string& extent, const std::string& data = "ascii\n1 2 3") {
  return Header(kXyz, extent, data);
}

INSTANTIATE_TEST_SUITE_P(
    InvalidFiles, HostilePcd,
    ::testing::Values(
        InvalidFile{"Magic", "PNG\r\n\x1a", "first line is PNG", "must start with"},
        InvalidFile{"Empty", "", "first line", "must start with"},
        InvalidFile{"Version", "VERSION 0.5\nDATA ascii\n", "VERSION is 0.5", "must be 0.7"},
        InvalidFile{"UnknownEntry", "VERSION 0.7\nCOLUMNS x\nDATA ascii\n", "COLUMNS",
                    "is not one of"},
        InvalidFile{"TwoWidths", Three("WIDTH 1\nWIDTH 1\nHEIGHT 1"), "WIDTH", "appears twice"},
        InvalidFile{"NoFields", "VERSION 0.7\nWIDTH 1\nHEIGHT 1\nDATA ascii\n", "FIELDS",
                    "is missing"},
        InvalidFile{"NoData", "VERSION 0.7\nFIELDS x\n", "DATA", "is missing"},
        InvalidFile{"NegativeWidth", Three("WIDTH -3\nHEIGHT 1"), "WIDTH is -3",
                    "must be an integer"},
        InvalidFile{"NegativeHeight", Three("WIDTH 1\nHEIGHT -1"), "HEIGHT is -1",
                    "must be an integer"},
        InvalidFile{"FractionalWidth", Three("WIDTH 1.5\nHEIGHT 1"), "WIDTH is 1.5",
                    "must be an integer"},
        InvalidFile{"WidthOutOfRange", Three("WIDTH 99999999999999999999\nHEIGHT 1"),
                    "WIDTH is 9999", "must be an integer from 0"},
        InvalidFile{"ExtentOverflow", Three("WIDTH 2147483647\nHEIGHT 2147483647", "binary\n"),
                    "POINTS is 4611686014132420609", "must be what the data holds"},
        InvalidFile{"CountLargerThanData", Three("WIDTH 2\nHEIGHT 1\nPOINTS 2"), "POINTS is 2",
                    "must be what the data holds"},
        InvalidFile{"CountSmallerThanData", Three("WIDTH 1\nHEIGHT 1", "ascii\n1 2 3\n4 5 6"),
                    "POINTS is 1", "more data after the last point"},
        InvalidFile{"PointsNotTheProduct", Three("WIDTH 1\nHEIGHT 1\nPOINTS 5"), "POINTS is 5",
                    "must be WIDTH x HEIGHT, 1"},
        InvalidFile{"NegativePoints", Three("WIDTH 1\nHEIGHT 1\nPOINTS -1"), "POINTS is -1",
                    "must be an integer"},
        InvalidFile{"UnknownType",
                    Header("FIELDS x\nSIZE 4\nTYPE Q\nCOUNT 1", "WIDTH 1\nHEIGHT 1", "ascii\n1"),
                    "field x is Q 4", "must be I or U"},
        InvalidFile{"UnknownSize",
                    Header("FIELDS x\nSIZE 3\nTYPE F\nCOUNT 1", "WIDTH 1\nHEIGHT 1", "ascii\n1"),
                    "field x is F 3", "F with 4 or 8"},
        InvalidFile{"NegativeSize",
                    Header("FIELDS x\nSIZE -4\nTYPE F\nCOUNT 1", "WIDTH 1\nHEIGHT 1", "ascii\n1"),
                    "field x is F -4", "F with 4 or 8"},
        InvalidFile{"NegativeCount",
                    Header("FIELDS x\nSIZE 4\nTYPE F\nCOUNT -1", "WIDTH 1\nHEIGHT 1", "ascii\n1"),
                    "COUNT of field x is -1", "must be an integer from 1"},
        InvalidFile{"AbsurdCount",
                    Header("FIELDS x y\nSIZE 8 8\nTYPE F F\nCOUNT 65536 65536", "WIDTH 1\nHEIGHT 1",
                           "binary\n"),
                    "size of a point is 1048576 bytes", "must be at most"},
        InvalidFile{
            "FewerTypesThanFields",
            Header("FIELDS x y\nSIZE 4 4\nTYPE F\nCOUNT 1 1", "WIDTH 1\nHEIGHT 1", "ascii\n1 2"),
            "number of TYPE entries is 1", "must be that of FIELDS, 2"},
        InvalidFile{
            "FieldTwice",
            Header("FIELDS x x\nSIZE 4 4\nTYPE F F\nCOUNT 1 1", "WIDTH 1\nHEIGHT 1", "ascii\n1 2"),
            "FIELDS is x", "must not appear twice"},
        InvalidFile{"UnknownData", Three("WIDTH 1\nHEIGHT 1", "zip\n"), "DATA is zip",
                    "must be ascii"},
        InvalidFile{
            "Viewpoint",
            "VERSION 0.7\nFIELDS x\nSIZE 4\nTYPE F\nWIDTH 0\nHEIGHT 1\nVIEWPOINT 0 0\nDATA ascii\n",
            "number of VIEWPOINT entries is 2", "must be 7"},
        InvalidFile{"TooFewValues", Three("WIDTH 1\nHEIGHT 1", "ascii\n1 2\n     \n"),
                    "number of values of point 0 is 2", "must be 3"},
        InvalidFile{"NotANumber", Three("WIDTH 1\nHEIGHT 1", "ascii\n1 2 3x"),
                    "point 0 field z is 3x", "must be of type float32"},
        InvalidFile{"IntegerOutOfRange",
                    Header("FIELDS x\nSIZE 1\nTYPE U\nCOUNT 1", "WIDTH 1\nHEIGHT 1", "ascii\n256"),
                    "point 0 field x is 256", "must be of type uint8"},
        InvalidFile{"NoCompressedSizes", Three("WIDTH 1\nHEIGHT 1", "binary_compressed\nabc"),
                    "data", "two sizes of four bytes"},
        InvalidFile{"CompressedSizeLies",
                    Three("WIDTH 1\nHEIGHT 1", "binary_compressed") +
                        Bytes<std::uint32_t>({4000000000u, 12}),
                    "compressed size is 4000000000", "0 bytes are left"},
        InvalidFile{
            "UncompressedSizeLies",
            Three("WIDTH 1\nHEIGHT 1", "binary_compressed") + Bytes<std::uint32_t>({2, 13}) + "ab",
            "uncompressed size is 13", "1 x 12 bytes"},
        InvalidFile{"ExpandsTooMuch",
                    Three("WIDTH 300000000\nHEIGHT 1", "binary_compressed") +
                        Bytes<std::uint32_t>({2, 3600000000u}) + "ab",
                    "compressed data is 2 bytes", "must unpack to exactly 3600000000"},
        InvalidFile{"CopiesFromBeforeTheBegin",
                    Three("WIDTH 1\nHEIGHT 1", "binary_compressed") +
                        Bytes<std::uint32_t>({3, 12}) + "\xe0\x03\x05",
                    "compressed data", "must unpack to exactly 12"}),
    [](const ::testing::TestParamInfo<InvalidFile>& info) { return std::string(info.param.name); });

TEST(CloudFile, ReplacesALabelInItsPlaceWhateverItsType) {
  const auto cloud =
      ParsePcd(Header("FIELDS x label y z\nSIZE 4 1 4 4\nTYPE F U F F\nCOUNT 1 1 1 1",
                      "WIDTH 2\nHEIGHT 1", "ascii\n1 7 2 3\n4 7 5 6"),
               "l.pcd");
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  const CloudFile labelled = WithLabels(*cloud, {70000, 3});
  EXPECT_THAT(Names(labelled), ElementsAre("x", "label", "y", "z"));
  EXPECT_EQ(labelled.Find("label")->size(), 4u);
  EXPECT_EQ(At(labelled, 0, "label"), 70000);
  EXPECT_EQ(At(labelled, 1, "label"), 3);
  EXPECT_EQ(At(labelled, 1, "z"), 6);
  EXPECT_EQ(SelectFields(labelled, {"x", "y", "z"}).bytes, Bytes<float>({1, 2, 3, 4, 5, 6}));
}

TEST(CloudFile, AppendsALabelWhereThereWasNone) {
  const auto cloud = ParsePcd(Three("WIDTH 1\nHEIGHT 1"), "l.pcd");
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_THAT(Names(WithLabels(*cloud, {5})), ElementsAre("x", "y", "z", "label"));
}

}  // namespace
}  // namespace cwm::formats
