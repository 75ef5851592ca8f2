#include "clients/cpp/point_labels.h"

#include <gtest/gtest.h>

namespace cwm::client {
namespace {

using Kind = PointOwner::Kind;

TEST(PointLabels, AreThoseOfTheScheme) {
  EXPECT_EQ(SupportLabel(0), 1U);
  EXPECT_EQ(SupportLabel(8), 9U);
  EXPECT_EQ(ObjectLabel(0), 20U);
  EXPECT_EQ(ObjectLabel(11), 130U);
}

TEST(PointLabels, LetTheTenthSupportShareTheNinthsLabel) { EXPECT_EQ(SupportLabel(9), 9U); }

TEST(PointLabels, LeadBackToTheirOwners) {
  EXPECT_EQ(PointOwnerOf(0), PointOwner());
  for (int i = 0; i < 9; ++i) {
    EXPECT_EQ(PointOwnerOf(SupportLabel(i)), (PointOwner{.kind = Kind::kSupport, .index = i}));
  }
  for (int i = 0; i < 100; ++i) {
    for (int part = 0; part < 10; ++part) {
      EXPECT_EQ(PointOwnerOf(ObjectLabel(i) + static_cast<std::uint32_t>(part)),
                (PointOwner{.kind = Kind::kObject, .index = i, .part = part}));
    }
  }
}

TEST(PointLabels, ThatNoScanGivesAreNobodys) {
  for (std::uint32_t label = 10; label < 20; ++label) {
    EXPECT_EQ(PointOwnerOf(label).kind, Kind::kNone) << label;
  }
}

}  // namespace
}  // namespace cwm::client
