// The calls of a page, and every way to close its socket.
#include <google/protobuf/descriptor.h>

#include <thread>

#include "server/web/readable_methods.h"
#include "tests/server/web/socket_fixture.h"

namespace cwm::server {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;
using testing::RawConnection;
using testing::RequestText;
using testing::WebSocketClient;

TEST_F(SocketTest, AnswersAreThoseOfTheServices) {
  PutBox("a", 1);
  PutBox("b", 2);
  v1::ListObjectsResponse direct;
  Call call;
  ASSERT_TRUE(world_->ListObjects(&call, {}, &direct).ok());
  ViewerPage page(port());
  const auto [messages, end] = page.Call(kList, "");
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(end.code(), 0) << end.message();
  v1::ListObjectsResponse bridged;
  ASSERT_TRUE(bridged.ParseFromString(messages[0]));
  EXPECT_EQ(bridged.objects_size(), 2);
  EXPECT_EQ(bridged.SerializeAsString(), direct.SerializeAsString());
}

TEST_F(SocketTest, ErrorsKeepTheirDetails) {
  PutBox("a", 1);
  v1::GetObjectRequest request;
  request.set_name("nobody");
  v1::GetObjectResponse response;
  Call call;
  const grpc::Status direct = world_->GetObject(&call, request, &response);
  ViewerPage page(port());
  const auto [messages, end] = page.Call(kGet, request.SerializeAsString());
  EXPECT_TRUE(messages.empty());
  EXPECT_EQ(end.code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(end.message(), direct.error_message());
  EXPECT_EQ(end.details(), direct.error_details());
  EXPECT_EQ(ReasonIn(direct), "OBJECT_UNKNOWN");
  const auto [none, malformed] = page.Call(kGet, "\xff\xff\xff");
  EXPECT_NE(malformed.code(), grpc::StatusCode::OK);
}

TEST_F(SocketTest, WhatDoesNotOnlyReadIsRefusedByItsName) {
  PutBox("a", 1);
  ViewerPage page(port());
  const auto* pool = google::protobuf::DescriptorPool::generated_pool();
  int readable = 0;
  for (const char* service :
       {"AdminService", "PerceptionService", "QueryService", "RobotService", "WorldService"}) {
    const auto* described = pool->FindServiceByName(std::string("cwm.v1.") + service);
    ASSERT_NE(described, nullptr);
    for (int i = 0; i < described->method_count(); ++i) {
      const std::string method = described->full_name() + "/" + described->method(i)->name();
      if (IsReadable(method)) {
        ++readable;
        continue;
      }
      const auto [messages, end] = page.Call(method, "");
      EXPECT_EQ(end.code(), grpc::StatusCode::PERMISSION_DENIED) << method;
      EXPECT_THAT(end.message(), HasSubstr(method));
      EXPECT_EQ(DetailsIn({grpc::StatusCode::UNKNOWN, "", end.details()}).info.reason(),
                "METHOD_NOT_READABLE");
    }
  }
  EXPECT_EQ(readable, static_cast<int>(ReadableMethods().size())) << "each of the table exists";
  for (const char* method : {"", "WatchWorld", "/cwm.v1.WorldService/WatchWorld",
                             "cwm.v1.WorldService/watchworld", "grpc.health.v1.Health/Check"}) {
    EXPECT_EQ(page.Call(method, "").second.code(), grpc::StatusCode::PERMISSION_DENIED) << method;
  }
  ExpectRevision(1);
}

TEST_F(SocketTest, AWatchTellsWhatAWatchOfGrpcTells) {
  PutBox("a", 1);
  v1::WatchWorldRequest request;
  ViewerPage page(port());
  page.Begin(7, kWatch, WatchRequest());
  Call call;
  const auto watch = world_->WatchWorld(&call, request);
  v1::WatchWorldResponse direct;
  ASSERT_TRUE(watch->Read(&direct));
  ASSERT_EQ(page.Next().message(), direct.SerializeAsString()) << "the state at the begin";
  for (int i = 0; i < 20; ++i) {
    if (i % 4 == 0) {
      PutBox("b" + std::to_string(i), i);
    } else {
      MoveBox("a", 100 + i);
    }
  }
  // Readers get revisions in different messages, but the same events.
  const auto events_until = [](std::int64_t revision, auto next) {
    std::vector<std::string> events;
    for (;;) {
      const v1::WatchWorldResponse message = next();
      for (const v1::ObjectEvent& event : message.events().events()) {
        events.push_back(event.SerializeAsString());
      }
      if (message.revision() >= revision || message.world_uid().empty()) return events;
    }
  };
  const auto bridged = events_until(21, [&] {
    v1::WatchWorldResponse message;
    const v1::ViewerResponse response = page.Next();
    EXPECT_EQ(response.call_id(), 7U);
    EXPECT_TRUE(message.ParseFromString(response.message()));
    return message;
  });
  const auto direct_events = events_until(21, [&] {
    v1::WatchWorldResponse message;
    EXPECT_TRUE(watch->Read(&message));
    return message;
  });
  EXPECT_EQ(bridged.size(), 20U);
  EXPECT_EQ(bridged, direct_events);
}

TEST_F(SocketTest, LargeStreamsArriveWhole) {
  std::string bytes;
  bytes.resize(9'000'000);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 7919 >> 5);
  const auto stored = application_.geometry.Put(BlobFormat::kLabelsU32, bytes);
  ASSERT_TRUE(stored.ok());
  v1::ReadGeometryRequest request;
  request.set_hash(stored->hash);
  ViewerPage page(port());
  const auto [messages, end] =
      page.Call("cwm.v1.WorldService/ReadGeometry", request.SerializeAsString());
  EXPECT_EQ(end.code(), 0) << end.message();
  std::string read;
  for (const std::string& message : messages) {
    v1::ReadGeometryResponse chunk;
    ASSERT_TRUE(chunk.ParseFromString(message));
    read += chunk.data();
  }
  EXPECT_TRUE(read == bytes);
}

TEST_F(SocketTest, CallsRunBesideEachOtherAndEndWhenCancelled) {
  PutBox("a", 1);
  ViewerPage page(port());
  page.Begin(1, kWatch, WatchRequest());
  EXPECT_EQ(page.Next().call_id(), 1U);
  page.Begin(2, kList, "");
  EXPECT_EQ(page.Next().call_id(), 2U);
  EXPECT_EQ(page.Next().end().code(), 0);
  page.Cancel(1);
  const v1::ViewerResponse cancelled = page.Next();
  EXPECT_EQ(cancelled.call_id(), 1U);
  EXPECT_EQ(cancelled.end().code(), grpc::StatusCode::CANCELLED);
  page.Cancel(1);            // is over already
  page.Cancel(99);           // never existed
  page.Begin(1, kList, "");  // the id can be used again
  EXPECT_EQ(page.Next().call_id(), 1U);
}

TEST_F(SocketTest, AWatchedWorldThatIsDeletedEndsTheCall) {
  PutBox("a", 1);
  ViewerPage page(port());
  page.Begin(1, kWatch, WatchRequest());
  page.Next();
  Call call;
  v1::DeleteWorldRequest request;
  v1::DeleteWorldResponse response;
  ASSERT_TRUE(world_->DeleteWorld(&call, request, &response).ok());
  v1::ViewerResponse last = page.Next();
  while (last.what_case() == v1::ViewerResponse::kMessage) last = page.Next();
  EXPECT_EQ(last.end().code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(SocketTest, TextIsRefused) {
  WebSocketClient socket(port());
  EXPECT_TRUE(socket.SendText("hello"));
  ExpectClosed(socket, 1003, "message: is text, must be a binary ViewerRequest");
}

TEST_F(SocketTest, BytesThatAreNoRequestAreRefused) {
  WebSocketClient socket(port());
  EXPECT_TRUE(socket.Send("\xff\xff\xff\xff"));
  ExpectClosed(socket, 1007, "message: must be a cwm.v1.ViewerRequest");
}

TEST_F(SocketTest, ARequestForNothingIsRefused) {
  WebSocketClient socket(port());
  v1::ViewerRequest request;
  request.set_call_id(1);
  EXPECT_TRUE(socket.Send(request.SerializeAsString()));
  ExpectClosed(socket, 1008, "what: is absent, must be one of begin, cancel");
  WebSocketClient empty(port());
  EXPECT_TRUE(empty.Send(""));
  ExpectClosed(empty, 1008, "what: is absent");
}

TEST_F(SocketTest, ANameOfACallUnderWayIsRefused) {
  PutBox("a", 1);
  ViewerPage page(port());
  page.Begin(5, kWatch, WatchRequest());
  page.Begin(5, kList, "");
  ExpectClosed(page.socket(), 1008, "call_id: is 5, must be of no call under way");
}

TEST_F(SocketTest, AMessageThatIsTooLargeIsRefused) {
  WebSocketClient socket(port());
  v1::ViewerRequest request;
  request.mutable_begin()->set_method(kList);
  request.mutable_begin()->set_request(std::string(ViewerLimits{}.message_bytes, 'a'));
  socket.Send(request.SerializeAsString());
  ExpectClosed(socket, 1009, "");
}

// Handshakes of faulty programs.
TEST_F(SocketTest, BadHandshakesAndFramesEndTheConnection) {
  const testing::HttpFields good = {{"Connection", "Upgrade"},
                                    {"Upgrade", "websocket"},
                                    {"Sec-WebSocket-Version", "13"},
                                    {"Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="}};
  for (std::size_t spoiled = 0; spoiled < 3; ++spoiled) {  // any key is valid
    testing::HttpFields fields = good;
    fields[spoiled].second = "nonsense";
    const auto answer = SendRequest("/socket", fields);
    EXPECT_TRUE(answer.status == 426 || answer.status == 400)
        << good[spoiled].first << " " << answer.status;
  }
  const std::string frames[] = {
      std::string("\x82\x05hello", 7),                                      // not masked
      std::string("\xff\x80\0\0\0\0", 6),                                   // an unknown opcode
      std::string("\x82\xff\x7f\xff\xff\xff\xff\xff\xff\xff\0\0\0\0", 14),  // of 2^63 bytes
      std::string("\x89\xfe\x01\x00\0\0\0\0", 8),                           // a ping of 256 bytes
      std::string("\x80\x80\0\0\0\0", 6),                                   // continues nothing
      std::string("\x88\x81\0\0\0\0\x03", 7),  // closes with half of a code
  };
  for (const std::string& frame : frames) {
    RawConnection connection(port());
    ASSERT_TRUE(connection.Send(RequestText(port(), "GET", "/socket", good)));
    EXPECT_EQ(connection.Receive().status, 101);
    SCOPED_TRACE(frame.size());
    connection.Send(frame);
    EXPECT_TRUE(connection.Ends(seconds(5)));
  }
  ExpectServes();
}

TEST_F(SocketTest, OriginsOfOthersAreRefused) {
  EXPECT_EQ(WebSocketClient(port(), {.fields = {{"Origin", "http://evil.example"}}}).status(), 403);
  const std::string own = "http://127.0.0.1:" + std::to_string(port());
  EXPECT_EQ(WebSocketClient(port(), {.fields = {{"Origin", own}}}).status(), 101);
  EXPECT_EQ(WebSocketClient(port(), {.fields = {{"Host", "evil.example"}}}).status(), 403);
}

TEST_F(SocketTest, WhoGoesLeavesNoCallBehind) {
  PutBox("a", 1);
  for (int i = 0; i < 300; ++i) {  // more than the limit of watches
    ViewerPage page(port());
    page.Begin(1, kWatch, WatchRequest());
    EXPECT_EQ(page.Next().what_case(), v1::ViewerResponse::kMessage) << i;
  }
}

TEST_F(SocketTest, AServerThatStopsSaysSo) {
  PutBox("a", 1);
  ViewerPage page(port());
  page.Begin(1, kWatch, WatchRequest());
  page.Next();
  WebSocketClient idle(port());
  RawConnection waiting(port());
  std::thread stop([this] { viewer_->Stop(); });
  for (WebSocketClient* socket : {&page.socket(), &idle}) {
    while (socket->Read(seconds(5))) {
    }
    EXPECT_EQ(socket->close_code(), 1001);
    EXPECT_EQ(socket->close_reason(), "the server stops");
  }
  EXPECT_TRUE(waiting.Ends(seconds(5)));
  stop.join();
  v1::ListWorldsResponse worlds;
  Call call;
  EXPECT_TRUE(world_->ListWorlds(&call, {}, &worlds).ok()) << "the services are still there";
}

TEST_F(SocketTest, AServerStopsThoughNobodyReads) {
  PutBox("a", 1);
  ViewerPage page(port());  // neither reads nor answers a close
  page.Begin(1, kWatch, WatchRequest());
  const auto start = std::chrono::steady_clock::now();
  viewer_->Stop();
  EXPECT_LT(std::chrono::steady_clock::now() - start, ViewerLimits{}.close_timeout + seconds(3));
}

}  // namespace
}  // namespace cwm::server
