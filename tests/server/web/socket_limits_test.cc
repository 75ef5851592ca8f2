// Limits of a page: calls, watches, time, waiting bytes.
#include <thread>

#include "tests/server/web/socket_fixture.h"

namespace cwm::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;
using testing::RawConnection;
using testing::RequestText;
using testing::WebSocketClient;

class ManyWatches : public SocketTest {
 protected:
  static ViewerLimits Limits() {
    ViewerLimits limits;
    limits.watches_of_socket = limits.calls_of_socket;
    return limits;
  }
  ManyWatches() : SocketTest(Limits()) {}
};

TEST_F(ManyWatches, TooManyCallsAreRefusedOneByOne) {
  PutBox("a", 1);
  ViewerPage page(port());
  const std::size_t max_calls = ViewerLimits{}.calls_of_socket;
  for (std::size_t i = 0; i < max_calls; ++i) page.Begin(i, kWatch, WatchRequest());
  for (std::size_t i = 0; i < max_calls; ++i) {
    EXPECT_EQ(page.Next().what_case(), v1::ViewerResponse::kMessage);
  }
  page.Begin(100, kList, "");
  const v1::ViewerResponse refused = page.Next();
  EXPECT_EQ(refused.call_id(), 100U);
  EXPECT_EQ(refused.end().code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(refused.end().message(), HasSubstr("16 calls"));
  page.Cancel(3);
  EXPECT_EQ(page.Next().end().code(), grpc::StatusCode::CANCELLED);
  page.Begin(100, kList, "");
  EXPECT_EQ(page.Next().what_case(), v1::ViewerResponse::kMessage);
}

TEST_F(SocketTest, APageWatchesTwoWorldsAtMost) {
  PutBox("a", 1);
  ViewerPage page(port());
  for (const std::uint64_t id : {1U, 2U}) {
    page.Begin(id, kWatch, WatchRequest());
    EXPECT_EQ(page.Next().what_case(), v1::ViewerResponse::kMessage);
  }
  page.Begin(3, kWatch, WatchRequest());
  const v1::ViewerResponse refused = page.Next();
  EXPECT_EQ(refused.call_id(), 3U);
  EXPECT_EQ(refused.end().code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(refused.end().message(), HasSubstr("2 watches of this socket"));
  // Watches that are about to end do not delay a page that switches from world to world.
  for (std::uint64_t id = 4; id < 12; ++id) {
    page.Cancel(id == 4 ? 1 : id - 1);
    page.Begin(id, kWatch, WatchRequest());
  }
  for (;;) {
    const v1::ViewerResponse response = page.Next();
    ASSERT_NE(response.what_case(), v1::ViewerResponse::WHAT_NOT_SET);
    ASSERT_NE(response.end().code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << response.call_id();
    if (response.call_id() == 11) break;
  }
}

class FewWatchers : public SocketTest {
 protected:
  static Limits OfServer() {
    Limits limits;
    limits.max_watchers = 1;
    limits.max_viewer_watchers = 2;
    return limits;
  }
  FewWatchers() : SocketTest(ViewerLimits{}, "", Files(), OfServer()) {}
};

TEST_F(FewWatchers, BrowsersAndProgramsTakeNoneFromEachOther) {
  PutBox("a", 1);
  ViewerPage first(port());
  ViewerPage second(port());
  for (ViewerPage* page : {&first, &second}) {
    page->Begin(1, kWatch, WatchRequest());
    EXPECT_EQ(page->Next().what_case(), v1::ViewerResponse::kMessage);
  }
  Call call;
  const auto watch = world_->WatchWorld(&call, {});
  v1::WatchWorldResponse message;
  EXPECT_TRUE(watch->Read(&message)) << "a robot's watch";
  second.Begin(2, kWatch, WatchRequest());
  const v1::ViewerResponse refused = second.Next();
  EXPECT_EQ(refused.end().code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(refused.end().message(), HasSubstr("2 watchers in browsers"));
  EXPECT_EQ(DetailsIn({grpc::StatusCode::UNKNOWN, "", refused.end().details()}).info.reason(),
            "TOO_MANY_VIEWERS");
  Call other;
  const auto one_too_many = world_->WatchWorld(&other, {});
  EXPECT_FALSE(one_too_many->Read(&message));
  EXPECT_EQ(ReasonIn(one_too_many->Finish()), "TOO_MANY_WATCHERS");
  second.Cancel(1);
  EXPECT_EQ(second.Next().end().code(), grpc::StatusCode::CANCELLED);
  // The services notice a moment later.
  v1::ViewerResponse admitted;
  for (std::uint64_t id = 3; id < 500 && admitted.message().empty(); ++id) {
    second.Begin(id, kWatch, WatchRequest());
    admitted = second.Next();
  }
  EXPECT_FALSE(admitted.message().empty());
}

class ShortCalls : public SocketTest {
 protected:
  static ViewerLimits Limits() {
    ViewerLimits limits;
    limits.call_timeout = milliseconds(300);
    return limits;
  }
  ShortCalls() : SocketTest(Limits()) {}
};

TEST_F(ShortCalls, ACallEndsInTimeAndAWatchDoesNot) {
  PutBox("a", 1);
  ViewerPage page(port());
  page.Begin(1, kWatch, WatchRequest());
  EXPECT_EQ(page.Next().call_id(), 1U);
  v1::GetObjectRequest waits;  // for a revision that is never made
  waits.set_name("a");
  waits.mutable_at_revision()->set_at_least(1'000);
  page.Begin(2, kGet, waits.SerializeAsString());
  const auto start = std::chrono::steady_clock::now();
  const v1::ViewerResponse late = page.Next(seconds(10));
  EXPECT_GE(std::chrono::steady_clock::now() - start, milliseconds(250));
  EXPECT_EQ(late.call_id(), 2U);
  EXPECT_EQ(late.end().code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_THAT(late.end().message(), HasSubstr("no answer within 300ms"));
  PutBox("b", 2);
  EXPECT_EQ(page.Next().what_case(), v1::ViewerResponse::kMessage) << "the watch goes on";
}

class SmallSockets : public SocketTest {
 protected:
  static ViewerLimits Limits() {
    ViewerLimits limits;
    limits.sockets = 2;
    limits.write_timeout = milliseconds(500);
    limits.ping_period = milliseconds(300);
    return limits;
  }
  SmallSockets() : SocketTest(Limits()) {}
};

TEST_F(SmallSockets, MoreThanThereMayBeAreRefused) {
  WebSocketClient first(port());
  auto second = std::make_unique<WebSocketClient>(port());
  EXPECT_EQ(second->status(), 101);
  EXPECT_EQ(WebSocketClient(port()).status(), 503);
  // A browser hides the reason from its page, which can request it without opening a socket.
  const testing::HttpResponse why = SendRequest("/socket");
  EXPECT_EQ(why.status, 503);
  EXPECT_THAT(why.body, HasSubstr("socket: there are 2 already, must be at most as many"));
  second.reset();
  int status = 0;
  for (int i = 0; i < 100 && status != 101; ++i) {
    std::this_thread::sleep_for(milliseconds(20));
    status = WebSocketClient(port()).status();
  }
  EXPECT_EQ(status, 101) << "there is room again";
}

TEST_F(SmallSockets, WhoAnswersNoPingIsGone) {
  RawConnection dead(port());
  ASSERT_TRUE(dead.Send(RequestText(port(), "GET", "/socket",
                                    {{"Connection", "Upgrade"},
                                     {"Upgrade", "websocket"},
                                     {"Sec-WebSocket-Version", "13"},
                                     {"Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="}})));
  EXPECT_EQ(dead.Receive().status, 101);
  WebSocketClient alive(port());
  bool ended = false;
  for (int i = 0; i < 100 && !ended; ++i) {
    EXPECT_FALSE(alive.Read(milliseconds(50)).has_value());  // answers pings meanwhile
    ended = dead.Ends(milliseconds(50));
  }
  EXPECT_TRUE(ended);
  EXPECT_FALSE(alive.closed());
}

TEST_F(SmallSockets, WhoTakesNoBytesIsGone) {
  std::string bytes;
  bytes.resize(40'000'000, 'a');
  const auto stored = application_.geometry.Put(BlobFormat::kLabelsU32, bytes);
  ASSERT_TRUE(stored.ok());
  v1::ReadGeometryRequest request;
  request.set_hash(stored->hash);
  ViewerPage page(port(), {.receive_bytes = 16 << 10});
  page.Begin(1, "cwm.v1.WorldService/ReadGeometry", request.SerializeAsString());
  std::this_thread::sleep_for(seconds(2));
  std::size_t read = 0;
  while (const auto message = page.socket().Read(seconds(2))) read += message->size();
  EXPECT_TRUE(page.socket().closed());
  EXPECT_LT(read, stored->hash.size() + 20'000'000);
  ExpectServes();
}

// Ten answers of 1 MiB at once for a page that reads nothing for a second.
class FewBytes : public SocketTest {
 protected:
  static constexpr std::uint64_t kCalls = 10;
  static constexpr auto kPause = milliseconds(1'000);
  static ViewerLimits Limits(milliseconds max_lag, std::size_t burst_bytes = 64 << 20) {
    ViewerLimits limits;
    limits.waiting_bytes = 3 << 20;
    limits.max_lag = max_lag;
    limits.burst_bytes = burst_bytes;
    return limits;
  }
  explicit FewBytes(const ViewerLimits& limits = Limits(kPause / 4)) : SocketTest(limits) {}

  struct Outcome {
    std::uint64_t whole = 0;
    std::uint64_t ended = 0;
    std::string why;  // the reason of the last ended call
  };
  static Outcome TakeAll(ViewerPage& page, milliseconds pause = {}) {
    Outcome outcome;
    while (outcome.whole + outcome.ended < kCalls) {
      const v1::ViewerResponse response = page.Next();
      EXPECT_NE(response.what_case(), v1::ViewerResponse::WHAT_NOT_SET);
      if (response.what_case() == v1::ViewerResponse::WHAT_NOT_SET) break;
      if (response.what_case() == v1::ViewerResponse::kMessage) {
        std::this_thread::sleep_for(pause);
        continue;
      }
      if (response.end().code() == grpc::StatusCode::OK) {
        ++outcome.whole;
        continue;
      }
      ++outcome.ended;
      outcome.why = response.end().message();
      EXPECT_EQ(response.end().code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << outcome.why;
      EXPECT_EQ(DetailsIn({grpc::StatusCode::UNKNOWN, "", response.end().details()}).info.reason(),
                "SOCKET_TOO_SLOW");
    }
    return outcome;
  }
  Outcome AskAndPause() {
    const auto stored =
        application_.geometry.Put(BlobFormat::kLabelsU32, std::string(1 << 20, 'a'));
    EXPECT_TRUE(stored.ok());
    v1::ReadGeometryRequest request;
    request.set_hash(stored->hash);
    ViewerPage page(port(), {.receive_bytes = 16 << 10});
    for (std::uint64_t id = 1; id <= kCalls; ++id) {
      page.Begin(id, "cwm.v1.WorldService/ReadGeometry", request.SerializeAsString());
    }
    std::this_thread::sleep_for(kPause);
    const Outcome outcome = TakeAll(page);
    const auto [messages, end] =
        page.Call("cwm.v1.WorldService/ReadGeometry", request.SerializeAsString());
    EXPECT_EQ(end.code(), 0) << "once it reads again it is served again";
    return outcome;
  }
};

// At most one message per call waits: with sixteen calls that could be 256 MiB.
TEST_F(FewBytes, WhatWaitsForASlowPageIsBounded) {
  const Outcome outcome = AskAndPause();
  EXPECT_THAT(outcome.why,
              HasSubstr("too slowly: more than 3145728 bytes waited for it for 250ms"));
  EXPECT_GE(outcome.whole, 3U) << "one that is written, and those that may wait";
  EXPECT_GE(outcome.ended, 3U);
}

class TimeToCatchUp : public FewBytes {
 protected:
  TimeToCatchUp() : FewBytes(Limits(10 * kPause)) {}
};

TEST_F(TimeToCatchUp, ABurstEndsNoCallOfAPageThatTakesItInTime) {
  const Outcome outcome = AskAndPause();
  EXPECT_EQ(outcome.whole, kCalls) << outcome.why;
}

class SmallBurst : public FewBytes {
 protected:
  SmallBurst() : FewBytes(Limits(10 * kPause, 5 << 20)) {}
};

TEST_F(SmallBurst, ABurstIsBoundedToo) {
  const Outcome outcome = AskAndPause();
  EXPECT_THAT(outcome.why, HasSubstr("too slowly: more than 5242880 bytes would wait for it"));
  EXPECT_GE(outcome.whole, 4U);
  EXPECT_GE(outcome.ended, 3U);
}

// For a page that reads 40 MiB/s, each message waits for a quarter of a second, so at any time more
// bytes wait than are allowed for long.
class SteadyReader : public FewBytes {
 protected:
  // Long enough that a machine with other work to do keeps it as well.
  static constexpr auto kMaxLag = 3 * kPause;
  SteadyReader() : FewBytes(Limits(kMaxLag)) {}
};

TEST_F(SteadyReader, APageThatKeepsUpIsServedHoweverMuchThereIs) {
  constexpr std::size_t kMessages = 16;
  const auto stored =
      application_.geometry.Put(BlobFormat::kLabelsU32, std::string(kMessages << 20, 'a'));
  ASSERT_TRUE(stored.ok());
  v1::ReadGeometryRequest request;
  request.set_hash(stored->hash);
  ViewerPage page(port(), {.receive_bytes = 16 << 10});
  const auto start = std::chrono::steady_clock::now();
  for (std::uint64_t id = 1; id <= kCalls; ++id) {
    page.Begin(id, "cwm.v1.WorldService/ReadGeometry", request.SerializeAsString());
  }
  const Outcome outcome = TakeAll(page, milliseconds(25));
  EXPECT_EQ(outcome.whole, kCalls) << outcome.why;
  EXPECT_GT(std::chrono::steady_clock::now() - start, kMaxLag) << "longer than may be";
}

// Each refusal is an answer: without a limit, a page that never reads would fill the memory.
TEST_F(SocketTest, WhoAsksWithoutReadingIsNotReadEither) {
  RawConnection client(port());
  ASSERT_TRUE(client.Send(RequestText(port(), "GET", "/socket",
                                      {{"Connection", "Upgrade"},
                                       {"Upgrade", "websocket"},
                                       {"Sec-WebSocket-Version", "13"},
                                       {"Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="}})));
  ASSERT_EQ(client.Receive().status, 101);
  v1::ViewerRequest request;
  request.mutable_begin()->set_method("no such method");
  const std::string payload = request.SerializeAsString();
  ASSERT_LT(payload.size(), 126U);
  std::string frame = "\x82";
  frame += static_cast<char>(0x80 | payload.size());
  frame += std::string(4, '\0') + payload;  // masked with zeros
  std::string many;
  for (int i = 0; i < 10'000; ++i) many += frame;
  std::size_t sent = 0;
  constexpr std::size_t kFarMoreThanBuffers = 64 << 20;
  while (sent < kFarMoreThanBuffers && client.Send(many, seconds(1))) sent += many.size();
  EXPECT_LT(sent, kFarMoreThanBuffers);
  ExpectServes();
}

// A page that sleeps gets the newest state when it wakes, not the intermediate ones.
TEST_F(SocketTest, ASlowPageGetsNewerStatesNotMoreOfThem) {
  constexpr int kBoxes = 50;
  constexpr int kMoves = 3'000;
  for (int i = 0; i < kBoxes; ++i) PutBox("box_" + std::to_string(i), i);
  ViewerPage page(port(), {.receive_bytes = 16 << 10});
  page.Begin(1, kWatch, WatchRequest(v1::WATCH_MODE_COALESCED));
  page.Next();
  for (int i = 0; i < kMoves; ++i) {
    v1::ApplyChangesRequest request;
    for (int k = 0; k < kBoxes; ++k) {
      v1::MoveObject* move = request.add_changes()->mutable_move();
      move->set_name("box_" + std::to_string(k));
      move->mutable_x_world_object()->set_tx_m(0.001 * (i + 1) + k);
      move->mutable_x_world_object()->set_qw(1);
    }
    v1::ApplyChangesResponse response;
    Call call;
    ASSERT_TRUE(world_->ApplyChanges(&call, request, &response).ok());
  }
  const std::int64_t last = kBoxes + kMoves;
  int messages = 0;
  std::int64_t revision = 0;
  double box_7_x_m = 0;
  while (revision < last) {
    const v1::ViewerResponse response = page.Next();
    v1::WatchWorldResponse message;
    ASSERT_EQ(response.what_case(), v1::ViewerResponse::kMessage);
    ASSERT_TRUE(message.ParseFromString(response.message()));
    for (const v1::ObjectEvent& event : message.events().events()) {
      if (event.move().name() == "box_7") box_7_x_m = event.move().x_world_object().tx_m();
    }
    revision = message.revision();
    ++messages;
  }
  EXPECT_LT(messages, kMoves / 3) << "of which most were in buffers when it fell asleep";
  EXPECT_DOUBLE_EQ(box_7_x_m, 0.001 * kMoves + 7);
}

}  // namespace
}  // namespace cwm::server
