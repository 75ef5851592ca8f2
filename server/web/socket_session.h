// A page's WebSocket: calls come in, their messages go out.
#pragma once

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "cwm/v1/viewer.pb.h"
#include "server/web/viewer_context.h"

namespace cwm::server {

// Forwards the page's calls to the services and their messages back. At most one message per call
// waits to be written, so a page that reads slowly delays only its own calls. If the waiting
// messages have too many bytes for too long, the newest calls among them are ended. Lives as long
// as one of its operations is in progress.
class SocketSession final : public Connection, public std::enable_shared_from_this<SocketSession> {
 public:
  SocketSession(boost::asio::ip::tcp::socket socket, std::optional<std::uint32_t> uid,
                ViewerContext& viewer);
  ~SocketSession() override;

  void Accept(HttpRequest request);
  void Close() override;
  bool is_idle() const override { return false; }

 private:
  using CloseCode = boost::beast::websocket::close_code;

  // A message to the page, and the call that continues once it is written.
  struct Outgoing {
    std::string bytes;
    std::uint64_t call_id = 0;
    bool call_goes_on = false;
    std::chrono::steady_clock::time_point since = {};  // when it began to wait
  };

  // A call in progress.
  struct PageCall {
    std::shared_ptr<BridgeCall> call;
    bool is_watch = false;
    bool is_cancelled = false;
    std::optional<grpc::Status> why = {};  // the status to report instead of the call's own
  };

  void Read();
  void OnRead(boost::beast::error_code error);
  void Begin(std::uint64_t id, const v1::ViewerCall& viewer_call);
  void Cancel(std::uint64_t id);
  // The reason why a call may not begin, if any.
  std::optional<grpc::Status> Refusal(const std::string& method) const;
  void End(std::uint64_t id, const grpc::Status& status);
  void SendMessage(std::uint64_t id, std::string message);
  void SendEnd(std::uint64_t id, const grpc::Status& status);
  void Send(const v1::ViewerResponse& response, bool call_goes_on);
  // If too many bytes wait, checks again when the oldest message has waited too long.
  void ScheduleLagCheck();
  void CheckLag();
  void WriteNext();
  void WritePiece();
  void Ping();
  // Sends the reason, and ends when the page has acknowledged it.
  void CloseWith(CloseCode code, std::string_view reason);
  void SendCloseFrame();
  void Abort();

  ViewerContext& viewer_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> stream_;
  boost::asio::steady_timer stall_timer_;
  boost::asio::steady_timer ping_timer_;
  boost::asio::steady_timer lag_timer_;
  boost::beast::flat_buffer input_;
  HttpRequest request_;  // until it is accepted
  std::unordered_map<std::uint64_t, PageCall> calls_;
  std::deque<Outgoing> waiting_;
  std::size_t waiting_bytes_ = 0;  // of waiting_
  Outgoing current_;               // being written
  std::size_t written_bytes_ = 0;
  bool writing_ = false;
  bool reading_ = false;
  bool received_since_ping_ = true;  // anything received since the last ping
  bool pinging_ = false;
  bool lag_check_pending_ = false;
  bool closing_ = false;
  bool aborted_ = false;
  boost::beast::websocket::close_reason close_reason_;
};

}  // namespace cwm::server
