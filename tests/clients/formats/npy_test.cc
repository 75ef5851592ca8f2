#include "clients/formats/npy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "clients/formats/file_bytes.h"
#include "tests/clients/formats/invalid_file.h"
#include "tests/support/process.h"

namespace cwm::formats {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

double At(const CloudFile& cloud, std::size_t point, const std::string& field) {
  const CloudField& f = *cloud.Find(field);
  return ToDouble(&cloud.bytes[point * cloud.point_step + f.offset], f.type);
}

std::string Bytes(const std::vector<float>& values) {
  std::string bytes(values.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

// A file by the format's description, without numpy's padding.
std::string Npy(const std::string& dictionary, const std::string& data, char version = 1) {
  std::string bytes = "\x93NUMPY";
  bytes += {version, '\0'};
  const auto size = static_cast<std::uint32_t>(dictionary.size());
  bytes.append(reinterpret_cast<const char*>(&size), version == 1 ? 2 : 4);
  return bytes + dictionary + data;
}

std::string Dictionary(const std::string& descr, const std::string& shape,
                       const std::string& fortran = "False") {
  return "{'descr': " + descr + ", 'fortran_order': " + fortran + ", 'shape': " + shape + ", }\n";
}

const std::string kTwo = Bytes({1, 2, 3, 4, 5, 6});

TEST(Npy, ReadsEveryVersion) {
  for (const char version : {1, 2, 3}) {
    const auto cloud = ParseNpy(Npy(Dictionary("'<f4'", "(2, 3)"), kTwo, version), "a.npy");
    ASSERT_TRUE(cloud.ok()) << cloud.status();
    EXPECT_EQ(cloud->width, 2);
    EXPECT_EQ(cloud->height, 1);
    EXPECT_EQ(cloud->bytes, kTwo);
  }
}

// Files written by numpy itself.
class NumpyFile : public ::testing::Test {
 protected:
  // Saves the array that the Python expression evaluates to.
  absl::StatusOr<CloudFile> Saved(const std::string& expression) const {
    const std::string file = scratch_ / "points.npy";
    const testing::ProcessResult run = testing::RunProgram(
        {"/usr/bin/python3", "-c",
         "import numpy as np, sys\na = np.arange(12.0).reshape(4, 3) / 8\n"
         "s = np.zeros(2, np.dtype([('label', 'u1'), ('x', '>f4'), ('y', '<f8'), ('z', '<i2'),"
         " ('rgb', 'u1', (3,)), ('nz', '<f4')], align=True))\n"
         "s['x'], s['y'], s['z'], s['rgb'], s['nz'] = 1.5, -2.25, 7, [1, 2, 3], 1\n"
         "np.save(sys.argv[1], " +
             expression + ", allow_pickle=True)",
         file});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return ParseNpy(ReadFileBytes(file).value(), "points.npy");
  }

 private:
  testing::ScratchDirectory scratch_;
};

TEST_F(NumpyFile, OfPlainPointsIsReadInEveryTypeAndOrder) {
  for (const char* expression :
       {"a", "a.astype('<f4')", "a.astype('>f4')", "a.astype('>f8')",
        "np.repeat(a, 2, axis=0)[::2]", "a[::-1][::-1]", "np.asfortranarray(a)",
        "np.asfortranarray(a.astype('>f4'))", "np.c_[a, np.ones(4)].astype('f4')",
        "np.asfortranarray(np.c_[a, np.ones((4, 3))])"}) {
    const auto cloud = Saved(expression);
    ASSERT_TRUE(cloud.ok()) << expression << ": " << cloud.status();
    ASSERT_EQ(cloud->size(), 4);
    EXPECT_EQ(At(*cloud, 0, "y"), 0.125) << expression;
    EXPECT_EQ(At(*cloud, 3, "x"), 9.0 / 8) << expression;
    EXPECT_EQ(At(*cloud, 3, "z"), 11.0 / 8) << expression;
  }
}

TEST_F(NumpyFile, OfAnImageIsAnOrganisedCloud) {
  for (const char* expression :
       {"a.reshape(2, 2, 3)", "np.asfortranarray(a.reshape(2, 2, 3))",
        "np.concatenate([a.reshape(2, 2, 3), np.ones((2, 2, 1))], axis=2)"}) {
    const auto cloud = Saved(expression);
    ASSERT_TRUE(cloud.ok()) << expression << ": " << cloud.status();
    EXPECT_EQ(cloud->height, 2);
    EXPECT_EQ(cloud->width, 2);
    EXPECT_EQ(At(*cloud, 1, "x"), 3.0 / 8) << expression;
    EXPECT_EQ(At(*cloud, 2, "x"), 6.0 / 8) << expression;
    EXPECT_EQ(At(*cloud, 3, "z"), 11.0 / 8) << expression;
  }
}

TEST_F(NumpyFile, OfAStructureIsReadByItsMembersWithoutThePadding) {
  for (const char* expression : {"s", "s.reshape(2, 1)", "np.asfortranarray(s.reshape(1, 2))"}) {
    const auto cloud = Saved(expression);
    ASSERT_TRUE(cloud.ok()) << cloud.status();
    EXPECT_EQ(cloud->size(), 2);
    EXPECT_EQ(cloud->fields.size(), 6U);
    EXPECT_EQ(At(*cloud, 1, "x"), 1.5);
    EXPECT_EQ(At(*cloud, 1, "y"), -2.25);
    EXPECT_EQ(At(*cloud, 1, "z"), 7);
    EXPECT_EQ(At(*cloud, 1, "normal_z"), 1);
    EXPECT_EQ(cloud->Find("rgb")->count, 3U);
  }
}

TEST_F(NumpyFile, OfAnythingElseIsRefused) {
  const auto refusal = [&](const std::string& expression) {
    return std::string(Saved(expression).status().message());
  };
  EXPECT_THAT(refusal("np.array([[1, 2, None]], object)"),
              AllOf(HasSubstr("descr is |O"), HasSubstr("objects are pickled and never read")));
  EXPECT_THAT(refusal("a.astype(int)"), HasSubstr("descr is <i8, must be <f4, <f8"));
  EXPECT_THAT(refusal("a.astype('<f2')"), HasSubstr("descr is <f2, must be"));
  EXPECT_THAT(refusal("a.astype(complex)"), HasSubstr("descr is <c16, must be"));
  EXPECT_THAT(refusal("np.zeros((3, 100))"), HasSubstr("shape is (3, 100), must be (N, 3)"));
  EXPECT_THAT(refusal("a.reshape(6, 2)"), HasSubstr("shape is (6, 2), must be (N, 3)"));
  EXPECT_THAT(refusal("a.reshape(12)"), HasSubstr("shape is (12), must be (N, 3)"));
  EXPECT_THAT(refusal("np.float64(1)"), HasSubstr("shape is (), must be (N, 3)"));
  EXPECT_THAT(refusal("s[['x', 'y']]"), HasSubstr("member z is missing"));
  EXPECT_THAT(refusal("s.reshape(2, 1, 1)"), HasSubstr("shape is (2, 1, 1), must be (N,)"));
}

class HostileNpy : public ::testing::TestWithParam<InvalidFile> {};

TEST_P(HostileNpy, IsRefusedNamingFileFieldAndRule) {
  ExpectRefusal(ParseNpy(GetParam().text, "hostile.npy").status(), "hostile.npy", GetParam());
}

std::string Plain(const std::string& shape) { return Npy(Dictionary("'<f4'", shape), kTwo); }
std::string Structure(const std::string& members) {
  return Npy(Dictionary("[" + members + "]", "(2,)"), kTwo);
}
const char kXyzMembers[] = "('x', '<f4'), ('y', '<f4'), ('z', '<f4')";

INSTANTIATE_TEST_SUITE_P(
    InvalidFiles, HostileNpy,
    ::testing::Values(
        InvalidFile{"Magic", "\x93NUMPX", "first bytes is ?NUMPX", "must be \\x93NUMPY"},
        InvalidFile{"Version", Npy(Dictionary("'<f4'", "(2, 3)"), kTwo, 4), "version is 4",
                    "1, 2 or 3"},
        InvalidFile{"HeaderLongerThanTheFile",
                    std::string("\x93NUMPY\x02\x00\xff\xff\xff\xff{}", 14),
                    "length of the header is 4294967295", "no more than the file of 14 bytes"},
        InvalidFile{"MorePointsThanData", Plain("(1000000000, 3)"), "shape is (1000000000, 3)",
                    "are not the 24 bytes that there are"},
        InvalidFile{"FewerPointsThanData", Plain("(1, 3)"), "shape is (1, 3)",
                    "1 points of 12 bytes are not the 24 bytes"},
        InvalidFile{"HalfAPoint", Npy(Dictionary("'<f4'", "(2, 3)"), kTwo + "x"), "shape is (2, 3)",
                    "not the 25 bytes"},
        InvalidFile{"ProductThatOverflows", Plain("(4294967296, 4294967296, 3)"),
                    "shape is (4294967296, 4294967296, 3)",
                    "must be at most 2147483647 points a side"},
        InvalidFile{"ShapeBeyondNumbers", Plain("(99999999999999999999, 3)"), "header at byte",
                    "a number from 0 to"},
        InvalidFile{"NegativeShape", Plain("(-2, 3)"), "is -2, 3)", "a number from 0 to"},
        InvalidFile{"NoShape", Npy("{'descr': '<f4', 'fortran_order': False}", kTwo),
                    "header at byte", "the keys descr, fortran_order and shape"},
        InvalidFile{"KeyTwice", Npy("{'shape': (2, 3), 'shape': (2, 3)}", kTwo), "header at byte",
                    "have each key once"},
        InvalidFile{"OtherKey", Npy("{'strides': (-12, 4)}", kTwo), "header at byte",
                    "the keys descr, fortran_order and shape alone"},
        InvalidFile{"CodeInTheHeader", Npy("__import__('os')", kTwo), "is __import__(",
                    "must have { here"},
        InvalidFile{"CodeForAShape", Plain("(2, int('3'))"), "is int('3'))", "a number from 0 to"},
        InvalidFile{"MoreAfterIt", Npy(Dictionary("'<f4'", "(2, 3)") + ", 1", kTwo),
                    "header at byte", "end with the dictionary"},
        InvalidFile{"StringWithoutEnd", Npy("{'descr", kTwo), "header at byte",
                    "must end its string"},
        InvalidFile{"NeitherTruth", Npy(Dictionary("'<f4'", "(2, 3)", "Maybe"), kTwo), "is Maybe",
                    "True or False"},
        InvalidFile{"EmptyType", Npy(Dictionary("''", "(2, 3)"), kTwo), "header at byte",
                    "name a type"},
        InvalidFile{"NoMembers", Structure(""), "descr", "must be <f4, <f8"},
        InvalidFile{"NativeOrder", Npy(Dictionary("'=f4'", "(2, 3)"), kTwo), "descr is =f4",
                    "must be <f4"},
        InvalidFile{"ObjectMember", Structure(std::string(kXyzMembers) + ", ('o', '|O')"),
                    "type of member \"o\" is |O", "objects are pickled"},
        InvalidFile{"TextMember", Structure(std::string(kXyzMembers) + ", ('s', '<U8')"),
                    "type of member \"s\" is <U8", "must be an integer or float"},
        InvalidFile{"MemberTwice", Structure(std::string(kXyzMembers) + ", ('x', '<f4')"),
                    "member is x", "must not appear twice"},
        InvalidFile{"StructureInAStructure", Structure("('p', [('x', '<f4')])"), "header at byte",
                    "not a structure in a structure"},
        InvalidFile{"HugeSubarray",
                    Structure(std::string(kXyzMembers) + ", ('d', '<f4', (65536, 65536))"),
                    "shape of member d is (65536, 65536)", "1 to 65536 numbers"},
        InvalidFile{"WidePoint", Structure(std::string(kXyzMembers) + ", ('d', '<f8', (65536,))"),
                    "type of member \"d\"", "must end within 65536"},
        InvalidFile{"EmptySubarray", Structure(std::string(kXyzMembers) + ", ('d', '<f4', (0,))"),
                    "shape of member d is (0)", "1 to 65536 numbers"},
        InvalidFile{"OddName", Structure("('a b', '<f4')"), "name of a member is \"a b\"",
                    "letters"}),
    [](const ::testing::TestParamInfo<InvalidFile>& info) { return std::string(info.param.name); });

TEST(Npy, FailsCleanlyWhenCutAtAnyByte) {
  for (const std::string& whole : {Plain("(2, 3)"), Structure(kXyzMembers)}) {
    ASSERT_TRUE(ParseNpy(whole, "whole.npy").ok());
    for (std::size_t size = 0; size < whole.size(); ++size) {
      ASSERT_EQ(ParseNpy(whole.substr(0, size), "cut.npy").status().code(),
                absl::StatusCode::kInvalidArgument)
          << "cut at " << size;
    }
  }
}

}  // namespace
}  // namespace cwm::formats
