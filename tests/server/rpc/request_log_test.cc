#include "server/rpc/request_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <sstream>

#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(LineLimit, AdmitsTenOfAKindInASecondAndCountsTheRest) {
  LineLimit limit;
  const Clock::time_point begin = Clock::now();
  for (int i = 0; i < 1'000; ++i) {
    EXPECT_EQ(limit.Admit("refused A", begin + milliseconds(i / 2)), i < kMaxLinesOfKind) << i;
  }
  EXPECT_TRUE(limit.Admit("refused B", begin + milliseconds(500))) << "another kind has its own";
  EXPECT_TRUE(limit.TakeOmitted(begin + milliseconds(999)).empty()) << "it is not over yet";
  const auto omitted = limit.TakeOmitted(begin + milliseconds(1'000));
  ASSERT_EQ(omitted.size(), 1U);
  EXPECT_EQ(omitted[0].kind, "refused A");
  EXPECT_EQ(omitted[0].lines, 1'000 - kMaxLinesOfKind);
  EXPECT_TRUE(limit.Admit("refused A", begin + milliseconds(1'000)));
  EXPECT_TRUE(limit.TakeOmitted(begin + std::chrono::hours(1)).empty()) << "each is told once";
}

TEST(LineLimit, AdmitsFiftyOfAllKindsTogether) {
  LineLimit limit;
  const Clock::time_point begin = Clock::now();
  std::int64_t admitted = 0;
  for (int i = 0; i < 1'000; ++i) admitted += limit.Admit(std::to_string(i % 100), begin) ? 1 : 0;
  EXPECT_EQ(admitted, kMaxLines);
  std::int64_t omitted = 0;
  for (const auto& kind : limit.TakeOmitted(begin + milliseconds(1'000))) omitted += kind.lines;
  EXPECT_EQ(omitted, 1'000 - kMaxLines);
}

TEST(RequestLog, ShowsNamesWithoutControlCharactersAndCutsThem) {
  EXPECT_EQ(QuoteForLog("table_1"), "\"table_1\"");
  EXPECT_EQ(QuoteForLog("a\nrefused \x1b[31m\xc2\x9b"), "\"a\\nrefused \\x1b[31m\\xc2\\x9b\"");
  EXPECT_EQ(QuoteForLog("say \"no\""), "\"say \\\"no\\\"\"");
  EXPECT_EQ(QuoteForLog(std::string(1'000, 'x')), "\"" + std::string(128, 'x') + "...\"");
}

// Captures log lines instead of writing them to the terminal.
class LoggingServerTest : public RunningServer {
 protected:
  LoggingServerTest() : before_(spdlog::default_logger()) {
    auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(lines_);
    spdlog::set_default_logger(std::make_shared<spdlog::logger>("test", std::move(sink)));
  }
  ~LoggingServerTest() override {
    server_ = nullptr;
    spdlog::set_default_logger(before_);
  }
  // The captured lines; stops the server first, so that no more are written.
  std::string Lines() {
    server_ = nullptr;
    return lines_.str();
  }

 private:
  std::ostringstream lines_;
  std::shared_ptr<spdlog::logger> before_;
};

TEST_F(LoggingServerTest, ACrowdOfRefusalsIsTenLinesAndANumber) {
  for (int i = 0; i < 500; ++i) {
    Call call;
    v1::GetWorldRequest request;
    request.set_world("secret content");
    v1::GetWorldResponse response;
    EXPECT_EQ(ReasonIn(world_->GetWorld(&call, request, &response)), "WORLD_UNKNOWN");
  }
  std::this_thread::sleep_for(milliseconds(1'200));
  std::istringstream lines(Lines());
  int refused = 0;
  int omitted = 0;
  for (std::string line; std::getline(lines, line);) {
    EXPECT_THAT(line, Not(HasSubstr("secret")));
    if (line.find("/cwm.v1.WorldService/GetWorld, NOT_FOUND, connection ") != std::string::npos) {
      ++refused;
    }
    const std::size_t more = line.find("refused WORLD_UNKNOWN: and ");
    if (more != std::string::npos) omitted += std::stoi(line.substr(more + 27));
  }
  EXPECT_EQ(refused + omitted, 500);
  EXPECT_GE(refused, kMaxLinesOfKind);
  EXPECT_LE(refused, 5 * kMaxLinesOfKind) << "500 calls take far less than five seconds";
}

TEST_F(LoggingServerTest, AStreamTellsWhichOfItsQueriesWereRefused) {
  {
    Call call;
    const auto stream = query_->StreamQueries(&call);
    v1::StreamQueriesRequest request;
    v1::StreamQueriesResponse response;
    ASSERT_TRUE(stream->Write(request) && stream->Read(&response));
    EXPECT_EQ(response.error().reason(), "INVALID_FIELD");
    ASSERT_TRUE(stream->WritesDone());
    EXPECT_TRUE(stream->Finish().ok());
  }
  EXPECT_THAT(Lines(), HasSubstr("refused INVALID_FIELD: /cwm.v1.QueryService/StreamQueries, "
                                 "INVALID_ARGUMENT, connection "));
}

TEST_F(LoggingServerTest, WorldsAreToldWhenTheyComeAndGo) {
  PutBox("a", 0, "kitchen");
  PutBox("b", 0, "kitchen");
  const std::string uid = (*application_.worlds.Find("kitchen"))->uid();
  Call call;
  v1::DeleteWorldRequest request;
  request.set_world("kitchen");
  v1::DeleteWorldResponse response;
  ASSERT_TRUE(world_->DeleteWorld(&call, request, &response).ok());
  const std::string lines = Lines();
  const std::string created = "world created: \"kitchen\", uid " + uid;
  ASSERT_THAT(lines, HasSubstr(created));
  EXPECT_EQ(lines.find(created), lines.rfind(created));
  EXPECT_LT(lines.find(created), lines.find("world deleted: \"kitchen\", uid " + uid));
}

}  // namespace
}  // namespace cwm::server
