#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

// One open watch.
class Watch {
 public:
  Watch(v1::WorldService::Stub& stub, const v1::WatchWorldRequest& request)
      : reader_(stub.WatchWorld(&call_, request)) {}
  ~Watch() { call_.TryCancel(); }

  // The next message that is no bookmark of idleness.
  v1::WatchWorldResponse Next() {
    v1::WatchWorldResponse message;
    do {
      if (!reader_->Read(&message)) return {};
    } while (message.has_bookmark());
    return message;
  }
  bool Read(v1::WatchWorldResponse* message) { return reader_->Read(message); }
  grpc::Status Finish() { return reader_->Finish(); }
  void Cancel() { call_.TryCancel(); }

 private:
  Call call_;
  std::unique_ptr<grpc::ClientReader<v1::WatchWorldResponse>> reader_;
};

class WatchTest : public RunningServer {};

TEST_F(WatchTest, ShowsTheWorldThenEveryChangeInOrder) {
  PutBox("a", 0);
  PutBox("b", 1);
  Watch watch(*world_, {});
  const auto initial = watch.Next();
  EXPECT_EQ(initial.revision(), 2);
  EXPECT_EQ(initial.initial_state().objects_size(), 2);
  EXPECT_TRUE(initial.initial_state().initial_state_done());
  for (int i = 3; i < 20; ++i) {
    PutBox("c", i);
    const auto event = watch.Next();
    EXPECT_EQ(event.revision(), i);
    ASSERT_EQ(event.events().events_size(), 1);
    EXPECT_EQ(event.events().events(0).has_put(), i == 3);
    EXPECT_EQ(event.events().events(0).has_move(), i != 3);
  }
}

TEST_F(WatchTest, ResumesAfterARevision) {
  for (int i = 0; i < 5; ++i) PutBox("box_" + std::to_string(i), i);
  v1::WatchWorldRequest request;
  request.set_from_revision(3);
  Watch watch(*world_, request);
  EXPECT_EQ(watch.Next().revision(), 4);
  EXPECT_EQ(watch.Next().revision(), 5);
}

TEST_F(WatchTest, AnIdleWatchSaysHowFarItHasCome) {
  PutBox("a", 0);
  Watch watch(*world_, {});
  watch.Next();
  v1::WatchWorldResponse message;
  ASSERT_TRUE(watch.Read(&message));
  EXPECT_TRUE(message.has_bookmark());
  EXPECT_EQ(message.revision(), 1);
}

TEST_F(WatchTest, TheFutureAndUnknownWorldsAreRefused) {
  PutBox("a", 0);
  v1::WatchWorldRequest request;
  request.set_from_revision(9);
  Watch future(*world_, request);
  v1::WatchWorldResponse message;
  EXPECT_FALSE(future.Read(&message));
  EXPECT_EQ(ReasonIn(future.Finish()), "REVISION_IN_FUTURE");
  request.Clear();
  request.set_world("elsewhere");
  Watch unknown(*world_, request);
  EXPECT_FALSE(unknown.Read(&message));
  EXPECT_EQ(ReasonIn(unknown.Finish()), "WORLD_UNKNOWN");
}

TEST_F(WatchTest, EndsWithTheWorld) {
  PutBox("a", 0);
  Watch watch(*world_, {});
  watch.Next();
  Call call;
  v1::DeleteWorldResponse deleted;
  ASSERT_TRUE(world_->DeleteWorld(&call, {}, &deleted).ok());
  v1::WatchWorldResponse message;
  EXPECT_FALSE(watch.Read(&message));
  EXPECT_EQ(ReasonIn(watch.Finish()), "WORLD_DELETED");
}

class FewWatchersTest : public RunningServer {
 protected:
  static Limits OneWatcher() {
    Limits limits;
    limits.max_watchers = 1;
    return limits;
  }
  FewWatchersTest() : RunningServer(OneWatcher(), {}) {}
};

TEST_F(FewWatchersTest, OneTooManyIsToldToComeBackAndCanOnceAnotherLeaves) {
  PutBox("a", 0);
  Watch first(*world_, {});
  first.Next();
  v1::WatchWorldResponse message;
  {
    Watch second(*world_, {});
    EXPECT_FALSE(second.Read(&message));
    const grpc::Status status = second.Finish();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
    EXPECT_EQ(ReasonIn(status), "TOO_MANY_WATCHERS");
    EXPECT_TRUE(DetailsIn(status).has_retry);
  }
  first.Cancel();
  // The server hears of it a moment later.
  bool admitted = false;
  for (int i = 0; i < 1'000 && !admitted; ++i) {
    Watch next(*world_, {});
    admitted = next.Read(&message);
  }
  EXPECT_TRUE(admitted);
}

}  // namespace
}  // namespace cwm::server
