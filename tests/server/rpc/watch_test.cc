#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

// An open watch.
class Watch {
 public:
  Watch(v1::WorldService::Stub& stub, const v1::WatchWorldRequest& request)
      : reader_(stub.WatchWorld(&call_, request)) {}
  ~Watch() { call_.TryCancel(); }

  // The next message that is not a bookmark.
  v1::WatchWorldResponse Next() { return NextMessage(reader_.get()); }
  bool Read(v1::WatchWorldResponse* message) { return reader_->Read(message); }
  grpc::Status Finish() { return reader_->Finish(); }
  void Cancel() { call_.TryCancel(); }

 private:
  Call call_;
  std::unique_ptr<grpc::ClientReader<v1::WatchWorldResponse>> reader_;
};

class WatchTest : public RunningServer {
 protected:
  std::string Uid() { return (*application_.worlds.Find(""))->uid(); }
};

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
  request.set_world_uid(Uid());
  Watch watch(*world_, request);
  EXPECT_EQ(watch.Next().revision(), 4);
  EXPECT_EQ(watch.Next().revision(), 5);
}

// Neither a restarted server nor a world's successor knows the earlier history.
TEST_F(WatchTest, ARevisionOfAnotherHistoryIsRefused) {
  for (int i = 0; i < 3; ++i) PutBox("before", i);
  const std::string before = Uid();
  Call call;
  v1::DeleteWorldResponse deleted;
  ASSERT_TRUE(world_->DeleteWorld(&call, {}, &deleted).ok());
  for (int i = 0; i < 5; ++i) PutBox("after", i);
  const auto refusal = [&](std::int64_t from, const std::string& uid) {
    v1::WatchWorldRequest request;
    request.set_from_revision(from);
    request.set_world_uid(uid);
    Watch watch(*world_, request);
    v1::WatchWorldResponse message;
    EXPECT_FALSE(watch.Read(&message));
    return watch.Finish();
  };
  EXPECT_EQ(ReasonIn(refusal(3, before)), "WORLD_REPLACED");
  const grpc::Status unsaid = refusal(3, "");
  EXPECT_EQ(unsaid.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(FieldIn(unsaid), "world_uid");
  EXPECT_THAT(unsaid.error_message(), ::testing::HasSubstr("revision 3"));
  // The first revision of this world, and revision 0 of any world.
  v1::WatchWorldRequest request;
  request.set_from_revision(1);
  request.set_world_uid(Uid());
  EXPECT_EQ(Watch(*world_, request).Next().revision(), 2);
  request.set_from_revision(0);
  request.clear_world_uid();
  EXPECT_EQ(Watch(*world_, request).Next().revision(), 1);
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
  request.set_world_uid(Uid());
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

v1::ApplyChangesRequest ManyBoxes(int count, double size_m) {
  v1::ApplyChangesRequest request;
  for (int i = 0; i < count; ++i) {
    v1::Change change = PutBoxChange("a_box_with_a_long_name_" + std::to_string(i), i);
    change.mutable_put()->mutable_object()->mutable_shapes(0)->mutable_box()->set_size_x_m(size_m);
    *request.add_changes() = std::move(change);
  }
  return request;
}

TEST_F(WatchTest, ARevisionThatIsTooLargeForOneMessageComesInPieces) {
  constexpr int kBoxes = 20'000;
  constexpr std::size_t kMaxBytes = 4 << 20;  // the default receive limit of gRPC clients
  PutBox("a", 0);
  Watch watch(*world_, {});
  watch.Next();
  Call call;
  v1::ApplyChangesResponse applied;
  const auto status = world_->ApplyChanges(&call, ManyBoxes(kBoxes, 0.2), &applied);
  ASSERT_TRUE(status.ok()) << status.error_message();
  int messages = 0;
  int events = 0;
  v1::WatchWorldResponse message;
  do {
    message = watch.Next();
    EXPECT_EQ(message.revision(), 2);
    EXPECT_LT(message.ByteSizeLong(), kMaxBytes / 2);
    events += message.events().events_size();
    ++messages;
  } while (message.events().more());
  EXPECT_GT(messages, 1);
  EXPECT_EQ(events, kBoxes);
  PutBox("b", 0);
  EXPECT_EQ(watch.Next().revision(), 3);
}

TEST_F(WatchTest, ACoalescedWatchTellsTheNewestStateOfEachObjectAndEveryRemoval) {
  PutBox("moving", 0);
  PutBox("going", 1);
  for (int i = 1; i <= 50; ++i) PutBox("moving", i);
  Call call;
  v1::ApplyChangesRequest removal;
  removal.add_changes()->mutable_remove()->set_name("going");
  v1::ApplyChangesResponse removed;
  ASSERT_TRUE(world_->ApplyChanges(&call, removal, &removed).ok());
  v1::WatchWorldRequest request;
  request.set_mode(v1::WATCH_MODE_COALESCED);
  request.set_from_revision(2);
  request.set_world_uid(Uid());
  Watch watch(*world_, request);
  const auto message = watch.Next();
  EXPECT_EQ(message.revision(), removed.revision());
  ASSERT_EQ(message.events().events_size(), 2);
  EXPECT_EQ(message.events().events(0).remove(), "going");
  EXPECT_EQ(message.events().events(1).move().x_world_object().tx_m(), 50);
}

TEST_F(WatchTest, AnIdleWatchTellsWhatScansSawAgain) {
  PutBox("a", 0);
  PutBox("b", 0);
  Watch watch(*world_, {});
  watch.Next();
  World& world = **application_.worlds.Find("");
  const std::vector<Sighting> seen = {{.name = "b"}};
  world.observations().Record(seen, std::chrono::system_clock::time_point(std::chrono::seconds(7)),
                              *world.Snapshot());
  v1::WatchWorldResponse message;
  ASSERT_TRUE(watch.Read(&message));
  ASSERT_TRUE(message.has_bookmark());
  ASSERT_EQ(message.bookmark().last_observed_size(), 1);
  EXPECT_EQ(message.bookmark().last_observed().at("b").seconds(), 7);
}

class ShortHistoryTest : public RunningServer {
 protected:
  static constexpr int kBoxes = 1'000;
  static Retention OneRevision() {
    Retention retention;
    retention.watch_events = kBoxes;
    return retention;
  }
  ShortHistoryTest() : RunningServer({}, OneRevision()) {}
};

TEST_F(ShortHistoryTest, EventsThatAreNoLongerKeptAreCompacted) {
  for (int i = 0; i < 2; ++i) {
    Call call;
    v1::ApplyChangesResponse applied;
    ASSERT_TRUE(world_->ApplyChanges(&call, ManyBoxes(kBoxes, 0.1 * (i + 1)), &applied).ok());
  }
  v1::WatchWorldRequest request;
  request.set_from_revision(0);
  Watch watch(*world_, request);
  v1::WatchWorldResponse message;
  EXPECT_FALSE(watch.Read(&message));
  const grpc::Status status = watch.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::OUT_OF_RANGE);
  EXPECT_EQ(ReasonIn(status), "REVISION_COMPACTED");
  EXPECT_EQ(DetailsIn(status).info.metadata().at("oldest_revision"), "1");
}

TEST_F(ShortHistoryTest, ALosslessReaderThatIsTooSlowIsEndedAndHoldsNobodyUp) {
  // Far more than sockets and gRPC's flow control hold for a client that does not read.
  constexpr int kRevisions = 100;
  PutBox("a", 0);
  Watch watch(*world_, {});
  watch.Next();
  for (int i = 0; i < kRevisions; ++i) {
    Call call;
    v1::ApplyChangesResponse applied;
    ASSERT_TRUE(
        world_->ApplyChanges(&call, ManyBoxes(kBoxes, 0.1 + 0.001 * (i + 1)), &applied).ok());
  }
  v1::WatchWorldResponse message;
  std::int64_t last = 1;
  while (watch.Read(&message)) {
    if (message.has_bookmark()) continue;
    EXPECT_EQ(message.revision(), last + 1) << "no revision is left out before the end";
    last = message.revision();
  }
  const grpc::Status status = watch.Finish();
  EXPECT_LT(last, kRevisions);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(ReasonIn(status), "WATCH_TOO_SLOW");
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
  // The server notices a moment later.
  bool admitted = false;
  for (int i = 0; i < 1'000 && !admitted; ++i) {
    Watch next(*world_, {});
    admitted = next.Read(&message);
  }
  EXPECT_TRUE(admitted);
}

}  // namespace
}  // namespace cwm::server
