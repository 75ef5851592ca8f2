#include "clients/cli/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <sstream>
#include <thread>

namespace cwm::cli {
namespace {

using ::testing::ContainsRegex;
using ::testing::EndsWith;
using ::testing::HasSubstr;

// 640 x 480 points of three floats; the first mebibyte is sent, at two per second.
const Transfer kKinect{.action = "sending",
                       .moved_bytes = 1 << 20,
                       .total_bytes = std::int64_t{307'200} * 12,
                       .bytes_per_s = 2 << 20,
                       .detail = "87381 of 307200 points"};

TEST(FormatTransfer, SaysBytesPointsRateAndTimeLeft) {
  // 2 637 824 bytes are left at 2 097 152 per second: 1.26 s, rounded up.
  EXPECT_EQ(FormatTransfer(kKinect),
            "sending 1.0 MB of 3.7 MB, 87381 of 307200 points, 2.1 MB/s, 2 s left");
  EXPECT_EQ(FormatCount(kKinect, 12, "points"), kKinect.detail);
}

TEST(FormatTransfer, ClaimsNoRateBeforeTimeHasPassed) {
  Transfer transfer = kKinect;
  transfer.bytes_per_s = 0;
  EXPECT_THAT(FormatTransfer(transfer), EndsWith("87381 of 307200 points"));
  transfer.detail = "";
  EXPECT_EQ(FormatTransfer(transfer), "sending 1.0 MB of 3.7 MB");
}

TEST(Progress, RewritesOneLineAndWipesIt) {
  std::ostringstream err;
  {
    Progress progress(err, ProgressStyle::kOneLine);
    progress.Update(kKinect);
    EXPECT_THAT(err.str(), HasSubstr("\r\033[Ksending 1.0 MB of 3.7 MB"));
    progress.ShowStage("the server interprets 307200 points");
    EXPECT_THAT(err.str(), HasSubstr("\r\033[Kthe server interprets 307200 points ..."));
  }
  EXPECT_THAT(err.str(), EndsWith("\r\033[K"));
  EXPECT_EQ(err.str().find('\n'), std::string::npos);
}

TEST(Progress, MeasuresTheRateFromTheFirstBytesOn) {
  std::ostringstream err;
  Progress progress(err, ProgressStyle::kOneLine);
  // The server's work before it sends must not count for the rate.
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  progress.Update({.action = "receiving", .moved_bytes = 1'000'000, .total_bytes = 62'000'000});
  EXPECT_THAT(err.str(), EndsWith("receiving 1.0 MB of 62.0 MB ..."));
  std::this_thread::sleep_for(std::chrono::milliseconds(10));
  progress.Update({.action = "receiving", .moved_bytes = 2'000'000, .total_bytes = 62'000'000});
  // 60 MB are left: at 1 MB in about 10 ms it takes a few seconds, at 2 MB in 410 ms it would take
  // 13.
  EXPECT_THAT(err.str(), ContainsRegex("MB/s, [1-5] s left ...$"));
}

TEST(Progress, IsSilentWhereNobodyWatches) {
  std::ostringstream err;
  Progress(err, ProgressStyle::kSilent).Update(kKinect);
  EXPECT_EQ(err.str(), "");
}

TEST(Progress, ShowsItselfOnATerminalAlone) {
  for (const bool terminal : {false, true}) {
    std::istringstream in;
    std::ostringstream out, err;
    const Session session({.in = in, .out = out, .err = err, .err_is_terminal = terminal});
    Progress(session).ShowStage("the server makes the file");
    EXPECT_EQ(err.str().empty(), !terminal);
    EXPECT_EQ(out.str(), "");
  }
}

}  // namespace
}  // namespace cwm::cli
