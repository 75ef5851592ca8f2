// A real server with a viewer in the test's own process, and a page that talks to it.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "cwm/v1/viewer.pb.h"
#include "server/web/viewer_server.h"
#include "tests/server/rpc/running_server.h"
#include "tests/support/web_client.h"

namespace cwm::server {

// Behaves like a page: makes calls over its socket.
class ViewerPage {
 public:
  explicit ViewerPage(int port, testing::WebSocketOptions options = {})
      : socket_(port, std::move(options)) {
    EXPECT_EQ(socket_.status(), 101);
  }

  void Begin(std::uint64_t id, const std::string& method, const std::string& request) {
    v1::ViewerRequest message;
    message.set_call_id(id);
    message.mutable_begin()->set_method(method);
    message.mutable_begin()->set_request(request);
    EXPECT_TRUE(socket_.Send(message.SerializeAsString()));
  }
  void Cancel(std::uint64_t id) {
    v1::ViewerRequest message;
    message.set_call_id(id);
    message.set_cancel(true);
    EXPECT_TRUE(socket_.Send(message.SerializeAsString()));
  }
  // Empty if nothing was received.
  v1::ViewerResponse Next(std::chrono::milliseconds patience = std::chrono::seconds(20)) {
    v1::ViewerResponse response;
    const auto bytes = socket_.Read(patience);
    if (bytes) {
      EXPECT_TRUE(response.ParseFromString(*bytes));
    }
    return response;
  }
  // All messages until the end of the only call.
  std::pair<std::vector<std::string>, v1::ViewerCallEnd> Call(const std::string& method,
                                                              const std::string& request) {
    std::vector<std::string> messages;
    Begin(1, method, request);
    for (;;) {
      const v1::ViewerResponse response = Next();
      if (response.what_case() != v1::ViewerResponse::kMessage) return {messages, response.end()};
      messages.push_back(response.message());
    }
  }
  testing::WebSocketClient& socket() { return socket_; }

 private:
  testing::WebSocketClient socket_;
};

class RunningViewer : public RunningServer {
 protected:
  static PageFiles Files() {
    return {.page = {.bytes = "<!doctype html>page"},
            .script = {.bytes = "script()", .gzip = "zipped"},
            .style = {.bytes = "body{}"}};
  }
  explicit RunningViewer(const ViewerLimits& limits = {}, const std::string& token = {},
                         const PageFiles& files = Files(), const Limits& of_server = {})
      : RunningServer(of_server, {}) {
    ViewerOptions options = At("127.0.0.1", 0);
    options.token = token;
    options.files = files;
    options.limits = limits;
    auto viewer = ViewerServer::Start(options, server_->InProcessChannel());
    if (!viewer.ok()) throw std::runtime_error(std::string(viewer.status().message()));
    viewer_ = *std::move(viewer);
  }
  void TearDown() override { viewer_->Stop(); }

  static ViewerOptions At(const std::string& host, int port) {
    ViewerOptions options;
    options.address.host = host;
    options.address.port = static_cast<std::uint16_t>(port);
    return options;
  }
  int port() const {
    const std::string& url = viewer_->urls().front();
    return std::stoi(url.substr(url.rfind(':') + 1));
  }
  testing::HttpResponse SendRequest(const std::string& target,
                                    const testing::HttpFields& fields = {},
                                    const std::string& method = "GET") const {
    return testing::SendRequest(port(), target, fields, method);
  }
  // Expects that other clients are served as usual.
  void ExpectServes() {
    EXPECT_EQ(SendRequest("/").status, 200);
    v1::ListWorldsResponse worlds;
    Call call;
    EXPECT_TRUE(world_->ListWorlds(&call, {}, &worlds).ok());
  }

  std::unique_ptr<ViewerServer> viewer_;
};

}  // namespace cwm::server
