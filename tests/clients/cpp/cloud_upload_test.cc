#include "clients/cpp/cloud_upload.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cwm::client {
namespace {

using formats::CloudField;
using formats::CloudFile;
using formats::Scalar;
using ::testing::HasSubstr;

CloudFile Cloud(std::vector<CloudField> fields) {
  CloudFile cloud;
  cloud.fields = std::move(fields);
  cloud.point_step = formats::AssignOffsets(cloud.fields);
  cloud.width = 3;
  cloud.bytes.assign(3 * cloud.point_step, '\1');
  return cloud;
}

TEST(SelectGeometry, TakesCoordinatesAndCompleteNormalsAlone) {
  const auto plain = SelectGeometry(Cloud({{.name = "label", .type = Scalar::kU32},
                                           {.name = "z"},
                                           {.name = "y"},
                                           {.name = "x"},
                                           {.name = "normal_x"}}));
  ASSERT_TRUE(plain.ok()) << plain.status();
  EXPECT_EQ(plain->point_step, 12u);
  EXPECT_EQ(plain->fields[0].name, "x");
  const auto normals = SelectGeometry(Cloud({{.name = "x"},
                                             {.name = "y"},
                                             {.name = "z"},
                                             {.name = "normal_z"},
                                             {.name = "normal_y"},
                                             {.name = "normal_x"}}));
  ASSERT_TRUE(normals.ok()) << normals.status();
  EXPECT_EQ(normals->point_step, 24u);
}

TEST(SelectGeometry, NamesTheCoordinateThatDoesNotDo) {
  const auto missing = SelectGeometry(Cloud({{.name = "x"}, {.name = "y"}}));
  EXPECT_THAT(std::string(missing.status().message()), HasSubstr("field z is missing"));
  const auto wide =
      SelectGeometry(Cloud({{.name = "x"}, {.name = "y", .type = Scalar::kI64}, {.name = "z"}}));
  EXPECT_THAT(std::string(wide.status().message()), HasSubstr("field y is 1 x int64"));
}

TEST(IngestCloud, SaysThatTheServerIsNotThere) {
  const Connection connection({.address = "unix:no-such-folder/no-such.sock", .deadline = {}});
  const auto response =
      IngestCloud(connection, {}, Cloud({{.name = "x"}, {.name = "y"}, {.name = "z"}}));
  EXPECT_EQ(response.status().code(), absl::StatusCode::kUnavailable) << response.status();
}

}  // namespace
}  // namespace cwm::client
