#include "clients/cli/scan_units.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>

namespace cwm::cli {
namespace {

using ::testing::HasSubstr;

// Points on a line before the sensor, at these distances.
formats::CloudFile At(const std::vector<float>& ranges) {
  formats::CloudFile cloud;
  cloud.fields = {{.name = "x"}, {.name = "y"}, {.name = "z"}};
  cloud.point_step = formats::LayOut(cloud.fields);
  cloud.width = static_cast<std::int64_t>(ranges.size());
  for (const float range : ranges) {
    const float point[3] = {0, 0, range};
    cloud.bytes.append(reinterpret_cast<const char*>(point), sizeof(point));
  }
  return cloud;
}

TEST(DoubtsAboutUnits, AreNoneForScansOfRoomsAndForWhatWasNotMeasured) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(DoubtsAboutUnits(At({0.5F, 2, 8})));
  EXPECT_FALSE(DoubtsAboutUnits(At({0.5F, 2, 8, nan, nan, nan, nan})));
  EXPECT_FALSE(DoubtsAboutUnits(At({nan})));
  EXPECT_FALSE(DoubtsAboutUnits(At({})));
}

TEST(DoubtsAboutUnits, AreSaidOfATableInMillimetresAndNotOfASingleWildPoint) {
  const auto doubts = DoubtsAboutUnits(At({500, 812, 2000}));
  ASSERT_TRUE(doubts.has_value());
  EXPECT_THAT(*doubts, HasSubstr("farther away than 812 m: coordinates are metres"));
  EXPECT_FALSE(DoubtsAboutUnits(At({0.5F, 0.8F, 2000})));
}

}  // namespace
}  // namespace cwm::cli
