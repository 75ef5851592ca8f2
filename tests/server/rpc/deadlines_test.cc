// Deadlines and time budgets in the middle of batches with large replies.
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cwm/v1/query.grpc.pb.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using std::chrono::milliseconds;
using ::testing::AllOf;
using ::testing::Gt;
using ::testing::Lt;

constexpr int kRows = 65'536, kResults = 16;

// Distances that take a few tenths of a second, and a reply of 98 MB, which takes longer than that.
class DeadlineTest : public RunningServer {
 protected:
  DeadlineTest() {
    for (int i = 0; i < kResults; ++i) PutBox("box_" + std::to_string(i), 0.3 * i);
    *request_.mutable_subject() = SphereAt(std::vector<double>(kRows, 2.05));
    request_.mutable_options()->set_max_results(kResults);
  }

  static bool IsPart(const v1::GetDistancesResponse& answer) {
    return answer.completed_count() > 0 && answer.completed_count() < kRows;
  }
  // Expects a non-empty, incomplete answer that is a prefix of `full`.
  void ExpectPrefix(const v1::GetDistancesResponse& part, const v1::GetDistancesResponse& full) {
    EXPECT_THAT(part.completed_count(), AllOf(Gt(0), Lt(kRows)));
    const std::string_view begins(part.columns().row_begin());
    EXPECT_EQ(begins.size(), (part.completed_count() + 1) * sizeof(std::uint32_t));
    EXPECT_TRUE(std::string_view(full.columns().row_begin()).starts_with(begins));
    const std::string_view distances_m(part.columns().distance_m());
    EXPECT_EQ(distances_m.size(),
              part.completed_count() * request_.options().max_results() * sizeof(double));
    EXPECT_TRUE(std::string_view(full.columns().distance_m()).starts_with(distances_m));
  }

  v1::GetDistancesRequest request_;
};

// Calls attempt(timeout), which returns true if a part of the answer came in time, with growing
// shares of the full answer's time on this machine until one succeeds. Other load of the machine
// may make some of them fail.
template <class Attempt>
void ExpectPartInTime(Clock::duration whole, const Attempt& attempt) {
  constexpr int kTimes = 3;
  for (int i = 0; i < kTimes; ++i) {
    for (const double share : {0.15, 0.25, 0.35, 0.5, 0.65, 0.8}) {
      if (attempt(std::chrono::duration_cast<milliseconds>(share * whole))) return;
    }
  }
  FAIL() << "no deadline was kept";
}

// If no time were reserved for the reply, every deadline before the full answer would end with
// DEADLINE_EXCEEDED.
TEST_F(DeadlineTest, ADeadlineInABatchGivesThePrefix) {
  v1::GetDistancesResponse full;
  Call unhurried;
  const auto begin = Clock::now();
  ASSERT_TRUE(query_->GetDistances(&unhurried, request_, &full).ok());
  ExpectPartInTime(Clock::now() - begin, [&](milliseconds timeout) {
    Call call(timeout);
    v1::GetDistancesResponse part;
    if (!query_->GetDistances(&call, request_, &part).ok()) return false;
    if (!IsPart(part)) return false;
    ExpectPrefix(part, full);
    return true;
  });
}

TEST_F(DeadlineTest, ADeadlineInABatchOfAStreamGivesThePrefix) {
  request_.mutable_options()->set_max_results(kResults / 4);  // 24 MB
  v1::GetDistancesResponse full;
  Call unhurried;
  const auto begin = Clock::now();
  ASSERT_TRUE(query_->GetDistances(&unhurried, request_, &full).ok());
  ExpectPartInTime(Clock::now() - begin, [&](milliseconds timeout) {
    Call call(timeout);
    const auto stream = query_->StreamQueries(&call);
    v1::StreamQueriesRequest request;
    *request.mutable_get_distances() = request_;
    v1::StreamQueriesResponse response;
    const bool is_told = stream->Write(request) && stream->Read(&response);
    stream->WritesDone();
    const grpc::Status status = stream->Finish();
    if (!is_told || !IsPart(response.get_distances())) return false;
    ExpectPrefix(response.get_distances(), full);
    return true;
  });
}

TEST_F(DeadlineTest, ADeadlineAmongAnswersInRowsGivesThePrefix) {
  for (int i = kResults; i < 64; ++i) PutBox("box_" + std::to_string(i), 0.3 * i);
  *request_.mutable_subject() = SphereAt(std::vector<double>(1'024, 2.05));
  request_.mutable_options()->set_max_results(64);
  request_.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  v1::GetDistancesResponse full;
  Call unhurried;
  const auto begin = Clock::now();
  ASSERT_TRUE(query_->GetDistances(&unhurried, request_, &full).ok());
  ExpectPartInTime(Clock::now() - begin, [&](milliseconds timeout) {
    Call call(timeout);
    v1::GetDistancesResponse part;
    if (!query_->GetDistances(&call, request_, &part).ok()) return false;
    if (part.completed_count() == 0 || part.completed_count() == 1'024) return false;
    EXPECT_EQ(part.rows_size(), part.completed_count());
    return true;
  });
}

TEST_F(DeadlineTest, ATimeBudgetInABatchGivesThePrefix) {
  v1::GetDistancesResponse full;
  Call unhurried;
  ASSERT_TRUE(query_->GetDistances(&unhurried, request_, &full).ok());
  // 100 ms is a part of the time on an otherwise idle machine; elsewhere the first rows take
  // longer.
  for (const int budget_ms : {100, 200, 400, 800}) {
    request_.mutable_options()->mutable_time_budget()->set_nanos(budget_ms * 1'000'000);
    Call call;
    v1::GetDistancesResponse part;
    ASSERT_TRUE(query_->GetDistances(&call, request_, &part).ok());
    if (part.completed_count() == 0) continue;
    ExpectPrefix(part, full);
    // 65 536 rows of 101 bytes for each of 16 results, at 4 ns per byte.
    EXPECT_LT(part.completed_count(), kRows / 4 * budget_ms / 100);
    return;
  }
  FAIL() << "no budget sufficed for a row";
}

}  // namespace
}  // namespace cwm::server
