#include "server/rpc/revision_waits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <latch>
#include <list>
#include <thread>

#include "server/core/error.h"
#include "tests/server/core/test_objects.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using namespace std::chrono_literals;

// The most waits of one client.
const std::int64_t kMaxWaits = Limits().max_client_waits;

class RevisionWaitsTest : public ::testing::Test {
 protected:
  ~RevisionWaitsTest() override { timer_.Stop(); }

  std::shared_ptr<World> world() { return *worlds_.FindOrCreate("w"); }
  void Publish() {
    const std::vector<collision::Change> changes = {Put("box")};
    ASSERT_TRUE(world()->Apply(changes, {}).ok());
  }
  RevisionWait ForOne(Clock::time_point deadline = Clock::time_point::max()) {
    return {.world = world(), .revision = collision::Revision{1}, .deadline = deadline, .stop = {}};
  }
  // The final status of a wait.
  absl::Status EndOf(RevisionWait wait) {
    const auto end = std::make_shared<std::promise<absl::Status>>();
    auto future = end->get_future();
    waits_.Await(std::move(wait), queue_, [end](absl::StatusOr<SnapshotPtr> snapshot) {
      end->set_value(snapshot.status());
    });
    return future.wait_for(30s) == std::future_status::ready ? future.get()
                                                             : absl::UnknownError("no end");
  }

  WorldRegistry worlds_{Limits{}, Retention{}};
  Timer timer_;
  RevisionWaits waits_{timer_, {.limit = 4 * kMaxWaits, .member_limit = kMaxWaits}};
  WorkQueue queue_{{.name = "test",
                    .threads = 1,
                    .capacity = 4,
                    .awaited_capacity = static_cast<std::size_t>(kMaxWaits)}};
};

TEST_F(RevisionWaitsTest, HoldNoWorkerAndNoPlaceAndAreAllAdmittedInTheirOrder) {
  std::vector<int> order;
  std::latch all(kMaxWaits);
  for (int i = 0; i < kMaxWaits; ++i) {
    waits_.Await(ForOne(), queue_, [&, i](absl::StatusOr<SnapshotPtr> snapshot) {
      EXPECT_TRUE(snapshot.ok() && (*snapshot)->revision().value == 1) << snapshot.status();
      order.push_back(i);  // one thread
      all.count_down();
    });
  }
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(queue_.waiting(), 0u);
  EXPECT_EQ(queue_.IdleFor(), Clock::duration::max()) << "no task was ever begun";
  Publish();
  all.wait();
  std::vector<int> arrival(kMaxWaits);
  for (int i = 0; i < kMaxWaits; ++i) arrival[i] = i;
  EXPECT_EQ(order, arrival);
}

TEST_F(RevisionWaitsTest, TakeNoPlaceOfThoseWhoComeMeanwhile) {
  std::promise<void> release;
  std::shared_future<void> released = release.get_future().share();
  std::promise<void> begun;
  ASSERT_TRUE(queue_.TryPush([&begun, released] {  // keeps its only thread busy
    begun.set_value();
    released.wait();
  }));
  begun.get_future().wait();
  std::atomic<int> admitted = 0;
  for (int i = 0; i < kMaxWaits; ++i) {
    waits_.Await(ForOne(), queue_, [&](absl::StatusOr<SnapshotPtr> snapshot) {
      EXPECT_TRUE(snapshot.ok()) << snapshot.status();
      ++admitted;
    });
  }
  Publish();
  while (queue_.waiting() < static_cast<std::size_t>(kMaxWaits)) std::this_thread::sleep_for(1ms);
  // All places of other clients are free, and each of their tasks waits for one admitted call, not
  // for all of them.
  std::vector<int> admitted_before;
  std::latch done(4);
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(queue_.TryPush([&] {
      admitted_before.push_back(admitted);
      done.count_down();
    })) << i;
  }
  // Admitted calls keep their place until they begin.
  EXPECT_EQ(EndOf({.world = world(),
                   .revision = collision::Revision{2},
                   .deadline = Clock::time_point::max(),
                   .stop = {}})
                .code(),
            absl::StatusCode::kResourceExhausted);
  release.set_value();
  done.wait();
  EXPECT_EQ(admitted_before, (std::vector<int>{0, 1, 2, 3}));
  queue_.Drain();
  EXPECT_EQ(admitted, kMaxWaits);
}

TEST_F(RevisionWaitsTest, EndWithTheirDeadlineCallerWorldOrServer) {
  EXPECT_EQ(EndOf(ForOne(Clock::now() + 20ms)).code(), absl::StatusCode::kDeadlineExceeded);
  std::stop_source gone;
  gone.request_stop();
  EXPECT_EQ(EndOf({.world = world(),
                   .revision = collision::Revision{1},
                   .deadline = Clock::time_point::max(),
                   .stop = gone.get_token()})
                .code(),
            absl::StatusCode::kCancelled);
  const RevisionWait orphan = ForOne();
  ASSERT_TRUE(worlds_.Delete("w").ok());
  EXPECT_EQ(DetailsOf(EndOf(orphan)).reason, "WORLD_DELETED");
  waits_.Drain();
  EXPECT_EQ(DetailsOf(EndOf(ForOne())).reason, "SERVER_DRAINING");
}

TEST_F(RevisionWaitsTest, ARevisionThatIsThereIsWorkAsAnyOther) {
  Publish();
  EXPECT_TRUE(EndOf(ForOne()).ok());
  queue_.Drain();
  EXPECT_EQ(DetailsOf(EndOf(ForOne())).reason, "SERVER_DRAINING");
}

// The same over a socket.
class WaitingClientsTest : public RunningServer {
 protected:
  // All calls are answered, however slow the machine is.
  static Limits Patient() {
    Limits limits;
    limits.max_queue_wait = std::chrono::minutes(5);
    return limits;
  }
  WaitingClientsTest() : RunningServer(Patient(), {}) {}

  // Enough rows that the queue of 64 fills up while the first calls are answered.
  static v1::GetDistancesRequest AtLeast(std::int64_t revision, std::size_t rows) {
    v1::GetDistancesRequest request;
    *request.mutable_subject() = SphereAt(std::vector<double>(rows, 0.5));
    request.mutable_options()->mutable_at_revision()->set_at_least(revision);
    return request;
  }
};

struct AsyncCall {
  Call context;
  v1::GetDistancesResponse response;
  grpc::Status status;
};

TEST_F(WaitingClientsTest, AllWhoWaitForOneRevisionAreAnsweredAndNobodyElseIsRefused) {
  constexpr int kStreams = 16;
  const int kCalls = static_cast<int>(kMaxWaits) - kStreams;
  PutBox("a", 0);
  const v1::GetDistancesRequest request = AtLeast(2, 4'000);
  const v1::GetDistancesRequest now = AtLeast(1, 1);
  const auto ask_now = [&] {
    Call call;
    v1::GetDistancesResponse response;
    const grpc::Status status = query_->GetDistances(&call, now, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
  };
  std::list<AsyncCall> calls(kCalls);
  std::latch answered(kCalls);
  int sent = 0;
  for (AsyncCall& call : calls) {
    // The queue holds 64 calls until they are read: on a slow machine more at once are refused.
    if (++sent % 32 == 0) ask_now();
    query_->async()->GetDistances(&call.context, &request, &call.response, [&](grpc::Status end) {
      call.status = std::move(end);
      answered.count_down();
    });
  }
  struct Stream {
    Call call;
    std::unique_ptr<grpc::ClientReaderWriter<v1::StreamQueriesRequest, v1::StreamQueriesResponse>>
        wire;
  };
  std::list<Stream> streams(kStreams);
  v1::StreamQueriesRequest query;
  *query.mutable_get_distances() = request;
  for (Stream& stream : streams) {
    stream.wire = query_->StreamQueries(&stream.call);
    ASSERT_TRUE(stream.wire->Write(query));
  }
  // A probe for a free place must not arrive before the last of them and take its place.
  for (int i = 0; i < 100; ++i) ask_now();
  // All of them wait once one more call is refused.
  const v1::GetDistancesRequest one_more = AtLeast(2, 1);
  const auto is_refused = [&] {
    Call call(50ms);
    v1::GetDistancesResponse response;
    const grpc::Status status = query_->GetDistances(&call, one_more, &response);
    return status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED &&
           ReasonIn(status) == "TOO_MANY_WAITS";
  };
  const auto give_up_at = Clock::now() + 30s;
  while (!is_refused()) ASSERT_LT(Clock::now(), give_up_at);
  PutBox("b", 1);
  while (!answered.try_wait()) ask_now();
  for (const AsyncCall& call : calls) {
    EXPECT_TRUE(call.status.ok()) << call.status.error_message();
    EXPECT_EQ(call.response.revision(), 2);
    EXPECT_EQ(call.response.completed_count(), 4'000);
  }
  for (Stream& stream : streams) {
    v1::StreamQueriesResponse response;
    ASSERT_TRUE(stream.wire->Read(&response));
    EXPECT_EQ(response.get_distances().revision(), 2) << response.error().message();
    stream.wire->WritesDone();
    EXPECT_TRUE(stream.wire->Finish().ok());
  }
  EXPECT_FALSE(is_refused()) << "their places are free again";
}

}  // namespace
}  // namespace cwm::server
