#include "server/web/socket_session.h"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "server/core/error.h"
#include "server/rpc/status_conversion.h"
#include "server/web/readable_methods.h"

namespace cwm::server {
namespace {

namespace websocket = boost::beast::websocket;
using boost::beast::error_code;

// chosen: a message is written in frames of so many bytes, each with its own timeout.
constexpr std::size_t kFramePieceBytes = 16 << 10;
// chosen: the kernel's send buffer of a socket. A larger one holds older states, so that a slow
// page lags more; this is enough for 1 GB/s at 0.25 ms.
constexpr int kSendBufferBytes = 256 << 10;
constexpr std::size_t kMaxCloseReasonBytes = 123;  // the limit of a close frame

grpc::Status NotReadable(const std::string& method) {
  constexpr std::size_t kShownBytes = 100;
  return ToGrpcStatus(MakeError(
      absl::StatusCode::kPermissionDenied,
      absl::StrCat("method: is \"", method.substr(0, kShownBytes),
                   "\", must be one that only reads; change the world by gRPC"),
      {.reason = "METHOD_NOT_READABLE", .metadata = {{"method", method.substr(0, kShownBytes)}}}));
}

grpc::Status TooMany(const char* what, std::size_t limit, const char* reason) {
  return ToGrpcStatus(Overloaded(absl::StrCat("there are ", limit, " ", what,
                                              " of this socket already, must be at most as many"),
                                 reason));
}

grpc::Status TooLong(std::chrono::milliseconds limit) {
  return ToGrpcStatus(MakeError(
      absl::StatusCode::kDeadlineExceeded,
      absl::StrCat("there was no answer within ", absl::FormatDuration(absl::FromChrono(limit)),
                   ", the most that a page waits; ask by gRPC with a deadline of your own"),
      {.reason = "CALL_TOO_LONG"}));
}

// `when` tells whether the bytes would wait, or have waited for some time.
grpc::Status TooSlow(std::size_t limit, const std::string& when) {
  return ToGrpcStatus(Overloaded(absl::StrCat("this socket is read too slowly: more than ", limit,
                                              " bytes ", when, ", must be at most as many"),
                                 "SOCKET_TOO_SLOW"));
}

}  // namespace

SocketSession::SocketSession(boost::asio::ip::tcp::socket socket, std::optional<std::uint32_t> uid,
                             ViewerContext& viewer)
    : Connection(viewer.connections, uid),
      viewer_(viewer),
      stream_(std::move(socket)),
      stall_timer_(viewer.bridge.context),
      ping_timer_(viewer.bridge.context),
      lag_timer_(viewer.bridge.context) {
  ++viewer_.connections.sockets;
}

SocketSession::~SocketSession() { --viewer_.connections.sockets; }

void SocketSession::Accept(HttpRequest request) {
  request_ = std::move(request);
  error_code ignored;
  auto& socket = boost::beast::get_lowest_layer(stream_).socket();
  socket.set_option(boost::asio::socket_base::send_buffer_size(kSendBufferBytes), ignored);
  socket.set_option(boost::asio::ip::tcp::no_delay(true), ignored);
  stream_.set_option(
      websocket::stream_base::timeout{.handshake_timeout = viewer_.limits.close_timeout,
                                      .idle_timeout = websocket::stream_base::none(),
                                      .keep_alive_pings = false});
  stream_.read_message_max(viewer_.limits.message_bytes);
  stream_.binary(true);
  stream_.auto_fragment(false);
  stream_.control_callback(
      [this](websocket::frame_type, boost::beast::string_view) { received_since_ping_ = true; });
  stream_.async_accept(request_, [self = shared_from_this()](error_code error) {
    if (error || self->aborted_) return self->Abort();
    if (self->closing_) return self->SendCloseFrame();  // decided during the handshake
    self->Read();
    self->Ping();
  });
}

void SocketSession::Read() {
  if (closing_ || reading_ || waiting_.size() > viewer_.limits.waiting_messages) return;
  reading_ = true;
  stream_.async_read(input_, [self = shared_from_this()](error_code error, std::size_t) {
    self->reading_ = false;
    self->OnRead(error);
  });
}

void SocketSession::OnRead(error_code error) {
  if (error) return Abort();  // the stream itself has reported a malformed frame
  received_since_ping_ = true;
  if (closing_) return;
  if (!stream_.got_binary()) {
    return CloseWith(CloseCode::unknown_data, "message: is text, must be a binary ViewerRequest");
  }
  v1::ViewerRequest request;
  const bool is_one = request.ParseFromArray(input_.data().data(), static_cast<int>(input_.size()));
  input_.consume(input_.size());
  if (!is_one) return CloseWith(CloseCode::bad_payload, "message: must be a cwm.v1.ViewerRequest");
  switch (request.what_case()) {
    case v1::ViewerRequest::kBegin:
      if (calls_.contains(request.call_id())) {
        return CloseWith(CloseCode::policy_error, absl::StrCat("call_id: is ", request.call_id(),
                                                               ", must be of no call under way"));
      }
      Begin(request.call_id(), request.begin());
      break;
    case v1::ViewerRequest::kCancel:
      Cancel(request.call_id());
      break;
    case v1::ViewerRequest::WHAT_NOT_SET:
      return CloseWith(CloseCode::policy_error, "what: is absent, must be one of begin, cancel");
  }
  Read();
}

std::optional<grpc::Status> SocketSession::Refusal(const std::string& method) const {
  const ViewerLimits& limits = viewer_.limits;
  if (!IsReadable(method)) return NotReadable(method);
  if (calls_.size() >= limits.calls_of_socket) {
    return TooMany("calls", limits.calls_of_socket, "TOO_MANY_CALLS");
  }
  // Cancelled watches are about to end and do not count, so that a page can change worlds quickly.
  const auto watches = std::count_if(calls_.begin(), calls_.end(), [](const auto& one) {
    return one.second.is_watch && !one.second.is_cancelled;
  });
  if (IsWatch(method) && static_cast<std::size_t>(watches) >= limits.watches_of_socket) {
    return TooMany("watches", limits.watches_of_socket, "TOO_MANY_VIEWERS");
  }
  return std::nullopt;
}

void SocketSession::Begin(std::uint64_t id, const v1::ViewerCall& viewer_call) {
  if (const auto refusal = Refusal(viewer_call.method())) return SendEnd(id, *refusal);
  const std::weak_ptr<SocketSession> weak = weak_from_this();
  BridgeCall::Request request{.method = viewer_call.method(), .body = viewer_call.request()};
  if (!IsStream(viewer_call.method())) request.timeout = viewer_.limits.call_timeout;
  PageCall& page_call = calls_[id];
  page_call.is_watch = IsWatch(viewer_call.method());
  page_call.call = BridgeCall::Start(viewer_.bridge, request,
                                     {.message =
                                          [weak, id](std::string message) {
                                            if (const auto self = weak.lock())
                                              self->SendMessage(id, std::move(message));
                                          },
                                      .end =
                                          [weak, id](const grpc::Status& status) {
                                            if (const auto self = weak.lock())
                                              self->End(id, status);
                                          }});
}

// Ignores a call that is already over: its end may be on its way to the page.
void SocketSession::Cancel(std::uint64_t id) {
  const auto page_call = calls_.find(id);
  if (page_call == calls_.end()) return;
  page_call->second.is_cancelled = true;
  page_call->second.call->Cancel();
}

void SocketSession::End(std::uint64_t id, const grpc::Status& status) {
  const auto page_call = calls_.find(id);
  if (closing_ || page_call == calls_.end()) return;
  grpc::Status reported = page_call->second.why.value_or(status);
  if (reported.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED) {
    reported = TooLong(viewer_.limits.call_timeout);
  }
  calls_.erase(page_call);
  SendEnd(id, reported);
}

void SocketSession::SendMessage(std::uint64_t id, std::string message) {
  const auto page_call = calls_.find(id);
  if (page_call == calls_.end()) return;
  const std::size_t limit = viewer_.limits.burst_bytes;
  if (!waiting_.empty() && waiting_bytes_ + message.size() > limit) {
    page_call->second.why = TooSlow(limit, "would wait for it");
    return Cancel(id);
  }
  v1::ViewerResponse response;
  response.set_call_id(id);
  response.set_message(std::move(message));
  Send(response, true);
  ScheduleLagCheck();
}

void SocketSession::ScheduleLagCheck() {
  if (closing_ || lag_check_pending_ || waiting_bytes_ <= viewer_.limits.waiting_bytes) return;
  lag_check_pending_ = true;
  lag_timer_.expires_at(waiting_.front().since + viewer_.limits.max_lag);
  lag_timer_.async_wait([weak = weak_from_this()](error_code error) {
    const auto self = weak.lock();
    if (!error && self != nullptr) self->CheckLag();
  });
}

// Messages wait in order of arrival: as long as the oldest is young, the page keeps up, however
// many bytes there are.
void SocketSession::CheckLag() {
  lag_check_pending_ = false;
  const ViewerLimits& limits = viewer_.limits;
  const auto too_old = std::chrono::steady_clock::now() - limits.max_lag;
  if (waiting_.empty() || waiting_.front().since > too_old) return ScheduleLagCheck();
  // Ends of calls are kept: they are small, and the page must get them.
  for (std::size_t i = waiting_.size() - 1; i > 0 && waiting_bytes_ > limits.waiting_bytes; --i) {
    if (!waiting_[i].call_goes_on) continue;
    const std::uint64_t id = waiting_[i].call_id;
    waiting_bytes_ -= waiting_[i].bytes.size();
    waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(i));
    const auto page_call = calls_.find(id);
    if (page_call == calls_.end() || page_call->second.is_cancelled)
      continue;  // cancelled by the page
    page_call->second.why = TooSlow(
        limits.waiting_bytes,
        absl::StrCat("waited for it for ", absl::FormatDuration(absl::FromChrono(limits.max_lag))));
    Cancel(id);
  }
}

void SocketSession::SendEnd(std::uint64_t id, const grpc::Status& status) {
  v1::ViewerResponse response;
  response.set_call_id(id);
  response.mutable_end()->set_code(status.error_code());
  response.mutable_end()->set_message(status.error_message());
  response.mutable_end()->set_details(status.error_details());
  Send(response, false);
}

void SocketSession::Send(const v1::ViewerResponse& response, bool call_goes_on) {
  if (closing_) return;
  waiting_.push_back({.bytes = response.SerializeAsString(),
                      .call_id = response.call_id(),
                      .call_goes_on = call_goes_on,
                      .since = std::chrono::steady_clock::now()});
  waiting_bytes_ += waiting_.back().bytes.size();
  if (!writing_) WriteNext();
}

void SocketSession::WriteNext() {
  if (waiting_.empty() || closing_) return;
  current_ = std::move(waiting_.front());
  waiting_.pop_front();
  waiting_bytes_ -= current_.bytes.size();
  written_bytes_ = 0;
  writing_ = true;
  WritePiece();
}

void SocketSession::WritePiece() {
  const std::size_t count = std::min(kFramePieceBytes, current_.bytes.size() - written_bytes_);
  const bool is_last = written_bytes_ + count == current_.bytes.size();
  stall_timer_.expires_after(viewer_.limits.write_timeout);
  stall_timer_.async_wait([weak = weak_from_this()](error_code error) {
    const auto self = weak.lock();
    if (!error && self != nullptr) self->Abort();
  });
  const auto piece = boost::asio::buffer(current_.bytes.data() + written_bytes_, count);
  written_bytes_ += count;
  stream_.async_write_some(is_last, piece,
                           [self = shared_from_this(), is_last](error_code error, std::size_t) {
                             if (error) return self->Abort();
                             if (self->closing_) return;
                             self->stall_timer_.cancel();
                             if (!is_last) return self->WritePiece();
                             self->writing_ = false;
                             const auto call = self->calls_.find(self->current_.call_id);
                             if (self->current_.call_goes_on && call != self->calls_.end())
                               call->second.call->ReadNext();
                             self->WriteNext();
                             self->Read();
                           });
}

// Drops a page that has not answered until the next ping, unless its messages are not being read.
void SocketSession::Ping() {
  if (closing_) return;
  if (reading_ && !received_since_ping_) return Abort();
  if (!pinging_) {  // the last ping may still wait for a message to be written
    received_since_ping_ = false;
    pinging_ = true;
    stream_.async_ping({}, [self = shared_from_this()](error_code error) {
      self->pinging_ = false;
      if (error && !self->closing_) self->Abort();
    });
  }
  ping_timer_.expires_after(viewer_.limits.ping_period);
  ping_timer_.async_wait([weak = weak_from_this()](error_code error) {
    const auto self = weak.lock();
    if (!error && self != nullptr) self->Ping();
  });
}

void SocketSession::Close() { CloseWith(CloseCode::going_away, "the server stops"); }

void SocketSession::CloseWith(CloseCode code, std::string_view reason) {
  if (closing_) return;
  closing_ = true;
  for (const auto& [id, page_call] : calls_) page_call.call->Cancel();
  calls_.clear();
  waiting_.clear();
  ping_timer_.cancel();
  lag_timer_.cancel();
  close_reason_ = {code, std::string(reason.substr(0, kMaxCloseReasonBytes))};
  stall_timer_.expires_after(viewer_.limits.close_timeout);
  stall_timer_.async_wait([weak = weak_from_this()](error_code error) {
    const auto self = weak.lock();
    if (!error && self != nullptr) self->Abort();
  });
  if (stream_.is_open()) SendCloseFrame();
}

void SocketSession::SendCloseFrame() {
  stream_.async_close(close_reason_, [self = shared_from_this()](error_code) { self->Abort(); });
}

void SocketSession::Abort() {
  closing_ = aborted_ = true;
  for (const auto& [id, page_call] : calls_) page_call.call->Cancel();
  calls_.clear();
  waiting_.clear();
  ping_timer_.cancel();
  lag_timer_.cancel();
  stall_timer_.cancel();
  boost::beast::get_lowest_layer(stream_).close();
}

}  // namespace cwm::server
