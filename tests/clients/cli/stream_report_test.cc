#include "clients/cli/stream_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using ::testing::HasSubstr;

// Latencies are counted in steps of 2 %.
constexpr double kStepShare = 0.02;

TEST(LatencyHistogram, TellsQuantilesToWithinAStep) {
  LatencyHistogram histogram;
  EXPECT_EQ(histogram.Quantile(0.5), 0);
  for (int i = 1; i <= 1000; ++i) histogram.Add(0.1 * i);
  EXPECT_NEAR(histogram.Quantile(0.5), 50, 50 * kStepShare);
  EXPECT_NEAR(histogram.Quantile(0.95), 95, 95 * kStepShare);
  EXPECT_NEAR(histogram.Quantile(1), 100, 100 * kStepShare);
  LatencyHistogram extremes;
  extremes.Add(0);
  extremes.Add(1e9);  // counted as the longest
  EXPECT_NEAR(extremes.Quantile(0.5), 0.01, 0.01 * kStepShare);
  EXPECT_NEAR(extremes.Quantile(1), 1e5, 1e5 * kStepShare);
}

pb::StreamCloudsResponse Answer(pb::FrameFate fate, const std::string& reason = "") {
  pb::StreamCloudsResponse answer;
  answer.set_fate(fate);
  answer.set_reason(reason);
  return answer;
}

TEST(StreamReport, CountsFatesReasonsAndChanges) {
  StreamReport report;
  StreamReport::Clock::time_point now{};
  pb::StreamCloudsResponse moved = Answer(pb::FRAME_FATE_PROCESSED);
  moved.set_revision(7);
  moved.mutable_changes()->add_moved("mug");
  moved.mutable_changes()->add_added("box");
  moved.mutable_changes()->add_movers("mover_1");
  for (int i = 0; i < 11; ++i) {
    now += milliseconds(100);
    report.Add(i == 3 ? moved : Answer(pb::FRAME_FATE_PROCESSED), milliseconds(20), now);
  }
  report.Add(Answer(pb::FRAME_FATE_DROPPED), milliseconds(1), now);
  report.Add(Answer(pb::FRAME_FATE_REFUSED, "STALE_FRAME"), milliseconds(1), now);
  report.Add(Answer(pb::FRAME_FATE_REFUSED, "STALE_FRAME"), milliseconds(1), now);
  EXPECT_EQ(report.processed(), 11);
  EXPECT_EQ(report.answered(), 14);
  EXPECT_EQ(report.reasons().at("STALE_FRAME"), 2);
  EXPECT_EQ(report.Line(), "14 frames, 10.0/s, latency 20.0 ms, 2 changes, 1 dropped, 2 refused");
  std::ostringstream out;
  report.Print(out);
  EXPECT_THAT(out.str(), HasSubstr("14 frames in 1.0 s, 13.7/s: 11 processed, 1 dropped, "
                                   "2 refused (2 STALE_FRAME)\n"));
  EXPECT_THAT(out.str(), HasSubstr("changes: 1 added, 1 moved, 0 replaced, 0 removed; movers in "
                                   "1 frames\nrevision 7\n"));
}

TEST(StreamReport, SaysNothingOfLatencyWithoutAProcessedFrame) {
  StreamReport report;
  report.Add(Answer(pb::FRAME_FATE_REFUSED), microseconds(5), {});
  std::ostringstream out;
  report.Print(out);
  EXPECT_THAT(out.str(), HasSubstr("1 refused (1 for no reason given)\n"));
  EXPECT_EQ(out.str().find("latency"), std::string::npos);
}

}  // namespace
}  // namespace cwm::cli
