#include "clients/cli/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace cwm::cli {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

// 640 x 480 points of three floats, the first mebibyte sent in half a second.
constexpr Upload kKinect{.sent_bytes = 1 << 20,
                         .total_bytes = std::int64_t{307'200} * 12,
                         .point_bytes = 12,
                         .elapsed_s = 0.5};

TEST(UploadText, SaysBytesPointsRateAndTimeLeft) {
  // 2 637 824 bytes are left at 2 097 152 a second: 1.26 s, rounded up.
  EXPECT_EQ(UploadText(kKinect),
            "sending 1.0 MB of 3.7 MB, 87381 of 307200 points, 2.1 MB/s, 2 s left");
}

TEST(UploadText, ClaimsNoRateBeforeTimeHasPassed) {
  Upload upload = kKinect;
  upload.elapsed_s = 0;
  EXPECT_THAT(UploadText(upload), EndsWith("87381 of 307200 points"));
}

TEST(Progress, RewritesOneLineAndWipesIt) {
  std::ostringstream err;
  {
    Progress progress(err, ProgressStyle::kOneLine);
    progress.Sent(kKinect);
    EXPECT_THAT(err.str(), HasSubstr("\r\033[Ksending 1.0 MB of 3.7 MB"));
    Upload all = kKinect;
    all.sent_bytes = all.total_bytes;
    progress.Sent(all);
    EXPECT_THAT(err.str(), HasSubstr("\r\033[Kthe server interprets 307200 points ..."));
  }
  EXPECT_THAT(err.str(), EndsWith("\r\033[K"));
  EXPECT_EQ(err.str().find('\n'), std::string::npos);
}

TEST(Progress, IsSilentWhereNobodyWatches) {
  std::ostringstream err;
  Progress(err, ProgressStyle::kSilent).Sent(kKinect);
  EXPECT_EQ(err.str(), "");
}

}  // namespace
}  // namespace cwm::cli
