// Pages with their sockets, and checks of how a socket is closed.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/server/web/running_viewer.h"

namespace cwm::server {

inline constexpr char kList[] = "cwm.v1.WorldService/ListObjects";
inline constexpr char kGet[] = "cwm.v1.WorldService/GetObject";
inline constexpr char kWatch[] = "cwm.v1.WorldService/WatchWorld";

class SocketTest : public RunningViewer {
 protected:
  using RunningViewer::RunningViewer;

  static std::string WatchRequest(v1::WatchMode mode = v1::WATCH_MODE_LOSSLESS) {
    v1::WatchWorldRequest request;
    request.set_mode(mode);
    return request.SerializeAsString();
  }
  void MoveBox(const std::string& name, double x_m) {
    v1::ApplyChangesRequest request;
    v1::MoveObject* move = request.add_changes()->mutable_move();
    move->set_name(name);
    move->mutable_x_world_object()->set_tx_m(x_m);
    move->mutable_x_world_object()->set_qw(1);
    v1::ApplyChangesResponse response;
    Call call;
    const auto status = world_->ApplyChanges(&call, request, &response);
    ASSERT_TRUE(status.ok()) << status.error_message();
  }
  // Expects that the socket is closed with a code and a reason.
  void ExpectClosed(testing::WebSocketClient& socket, int code, const std::string& reason) {
    while (socket.Read()) {
    }
    EXPECT_TRUE(socket.closed());
    EXPECT_EQ(socket.close_code(), code);
    EXPECT_THAT(socket.close_reason(), ::testing::HasSubstr(reason));
    ExpectServes();
  }
};

}  // namespace cwm::server
