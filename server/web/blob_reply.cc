#include "server/web/blob_reply.h"

#include <boost/asio/buffer.hpp>
#include <boost/beast/http/serializer.hpp>
#include <boost/beast/http/write.hpp>
#include <memory>
#include <utility>

#include "cwm/v1/world.pb.h"

namespace cwm::server {
namespace {

using boost::beast::error_code;

http::status StatusOf(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::NOT_FOUND:
      return http::status::not_found;
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
    case grpc::StatusCode::UNAVAILABLE:
      return http::status::service_unavailable;
    default:
      return http::status::internal_server_error;
  }
}

// A blob being sent: each chunk is read after the previous one was written.
class BlobTransfer : public std::enable_shared_from_this<BlobTransfer> {
 public:
  BlobTransfer(boost::beast::tcp_stream& stream, ViewerContext& viewer,
               const BlobReply::Request& request, std::function<void(BlobReply::Outcome)> done)
      : stream_(stream),
        limits_(viewer.limits),
        request_(request.http),
        etag_("\"" + request.hash + "\""),
        done_(std::move(done)) {}

  void Begin(Bridge& bridge, const std::string& hash) {
    v1::ReadGeometryRequest request;
    request.set_hash(hash);
    const std::string method = "cwm.v1.WorldService/ReadGeometry";
    call_ = BridgeCall::Start(
        bridge, {.method = method, .body = request.SerializeAsString()},
        {.message = [self = shared_from_this()](std::string bytes) { self->OnMessage(bytes); },
         .end = [self = shared_from_this()](const grpc::Status& status) { self->End(status); }});
  }

 private:
  void OnMessage(const std::string& bytes) {
    if (!chunk_.ParseFromString(bytes)) return Fail();
    if (header_.has_value()) return WriteChunk();
    MakeHeader();
    stream_.expires_after(limits_.write_timeout);
    serializer_.emplace(*header_);
    http::async_write_header(stream_, *serializer_,
                             [self = shared_from_this()](error_code error, std::size_t) {
                               if (error) return self->Fail();
                               if (self->is_head()) return self->call_->Cancel();
                               self->WriteChunk();
                             });
  }

  void MakeHeader() {
    header_.emplace(http::status::ok, request_.version());
    SetSecurityHeaders(*header_);
    header_->set(http::field::content_type, "application/octet-stream");
    header_->set(http::field::cache_control, "public, max-age=31536000, immutable");
    header_->set(http::field::etag, etag_);
    header_->keep_alive(request_.keep_alive());
    header_->content_length(static_cast<std::uint64_t>(chunk_.total_bytes()));
  }

  // Writes as much as the stream takes at a time; each write has its own timeout.
  void WriteChunk(std::size_t from = 0) {
    if (from == chunk_.data().size()) {
      is_whole_ = chunk_.done();
      return call_->ReadNext();
    }
    stream_.expires_after(limits_.write_timeout);
    stream_.async_write_some(
        boost::asio::buffer(chunk_.data()) + from,
        [self = shared_from_this(), from](error_code error, std::size_t written) {
          if (error) return self->Fail();
          self->WriteChunk(from + written);
        });
  }

  void Fail() {
    failed_ = true;
    call_->Cancel();
  }

  void End(const grpc::Status& status) {
    call_.reset();
    if (!header_.has_value() && !failed_) {
      const std::string& why = status.ok() ? "the answer was empty" : status.error_message();
      return done_({.refusal = TextReply(request_, StatusOf(status.error_code()), why)});
    }
    const bool is_whole = !failed_ && (is_head() || (is_whole_ && status.ok()));
    done_({.keep_alive = is_whole && request_.keep_alive()});
  }

  bool is_head() const { return request_.method() == http::verb::head; }

  boost::beast::tcp_stream& stream_;
  const ViewerLimits& limits_;
  const HttpRequest request_;
  const std::string etag_;
  const std::function<void(BlobReply::Outcome)> done_;
  std::shared_ptr<BridgeCall> call_;
  v1::ReadGeometryResponse chunk_;
  std::optional<http::response<http::empty_body>> header_;
  std::optional<http::response_serializer<http::empty_body>> serializer_;
  bool is_whole_ = false;
  bool failed_ = false;
};

}  // namespace

void BlobReply::Start(boost::beast::tcp_stream& stream, ViewerContext& viewer,
                      const Request& request, std::function<void(Outcome)> done) {
  std::make_shared<BlobTransfer>(stream, viewer, request, std::move(done))
      ->Begin(viewer.bridge, request.hash);
}

}  // namespace cwm::server
