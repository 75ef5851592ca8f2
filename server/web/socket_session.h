// A page's WebSocket: calls in, their messages out.
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
#include "server/web/house.h"

namespace cwm::server {

// Carries each call of the page to the services and back. Of each call one message at most waits to
// be written, so a page that reads slowly holds up its own calls and nothing else; where those that
// wait are too many bytes together for too long, the calls of the last ones end. Lives as long as
// an operation of its own is under way.
class SocketSession final : public Guest, public std::enable_shared_from_this<SocketSession> {
 public:
  SocketSession(boost::asio::ip::tcp::socket socket, std::optional<std::uint32_t> uid,
                House& house);
  ~SocketSession() override;

  void Accept(HttpRequest request);
  void Leave() override;
  bool waits() const override { return false; }

 private:
  using CloseCode = boost::beast::websocket::close_code;

  // A message to the page, and the call that goes on once it is written.
  struct Outgoing {
    std::string bytes;
    std::uint64_t call_id = 0;
    bool call_goes_on = false;
    std::chrono::steady_clock::time_point since = {};  // it waits
  };

  // A call under way.
  struct Carried {
    std::shared_ptr<BridgeCall> call;
    bool is_watch = false;
    bool is_cancelled = false;
    std::optional<grpc::Status> why = {};  // it ends, other than it says itself
  };

  void Read();
  void Take(boost::beast::error_code error);
  void Begin(std::uint64_t id, const v1::ViewerCall& asked);
  void Cancel(std::uint64_t id);
  // A call that may not begin: why.
  std::optional<grpc::Status> Refusal(const std::string& method) const;
  void End(std::uint64_t id, const grpc::Status& status);
  void SendMessage(std::uint64_t id, std::string message);
  void SendEnd(std::uint64_t id, const grpc::Status& status);
  void Send(const v1::ViewerResponse& response, bool call_goes_on);
  // Where more waits than may for long: looks again when the first of it has waited too long.
  void ExpectCatchingUp();
  void CheckCatchingUp();
  void WriteNext();
  void WritePiece();
  void Ping();
  // Says why, and ends when the page has heard it.
  void Close(CloseCode code, std::string_view reason);
  void SayGoodbye();
  void Drop();

  House& house_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> stream_;
  boost::asio::steady_timer stall_timer_;
  boost::asio::steady_timer ping_timer_;
  boost::asio::steady_timer catch_up_timer_;
  boost::beast::flat_buffer input_;
  HttpRequest request_;  // while it is accepted
  std::unordered_map<std::uint64_t, Carried> calls_;
  std::deque<Outgoing> waiting_;
  std::size_t waiting_bytes_ = 0;  // of those
  Outgoing written_;               // being written
  std::size_t written_to_ = 0;
  bool writing_ = false;
  bool reading_ = false;
  bool heard_ = true;  // since the last ping
  bool pinging_ = false;
  bool catching_up_ = false;
  bool closing_ = false;
  bool dropped_ = false;
  boost::beast::websocket::close_reason goodbye_;
};

}  // namespace cwm::server
