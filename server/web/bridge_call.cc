#include "server/web/bridge_call.h"

#include <boost/asio/post.hpp>
#include <utility>
#include <vector>

namespace cwm::server {
namespace {

std::string BytesOf(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  std::string bytes;
  if (!buffer.Dump(&slices).ok()) return bytes;
  bytes.reserve(buffer.Length());
  for (const grpc::Slice& slice : slices) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  return bytes;
}

}  // namespace

std::shared_ptr<BridgeCall> BridgeCall::Start(Bridge& bridge, const Request& request,
                                              Listener listener) {
  const std::shared_ptr<BridgeCall> call(new BridgeCall(bridge, std::move(listener)));
  call->self_ = call;
  if (request.timeout)
    call->call_.set_deadline(std::chrono::system_clock::now() + *request.timeout);
  const grpc::Slice slice(request.body);
  call->request_ = grpc::ByteBuffer(&slice, 1);
  bridge.services.PrepareBidiStreamingCall(&call->call_, "/" + request.method, {}, call.get());
  call->AddHold();  // since reads are started outside of the reactor's callbacks
  call->StartWriteLast(&call->request_, {});
  call->StartRead(&call->response_);
  call->StartCall();
  return call;
}

BridgeCall::BridgeCall(Bridge& bridge, Listener listener)
    : context_(bridge.context),
      work_(bridge.context.get_executor()),
      listener_(std::move(listener)) {}

void BridgeCall::ReadNext() {
  if (!std::exchange(delivered_, false)) return;
  StartRead(&response_);
}

void BridgeCall::Cancel() {
  if (std::exchange(cancelled_, true)) return;
  call_.TryCancel();
  ReadNext();  // the last read removes the hold
}

void BridgeCall::OnReadDone(bool ok) {
  if (!ok) return RemoveHold();
  boost::asio::post(context_, [self = self_, message = BytesOf(response_)]() mutable {
    self->Deliver(std::move(message));
  });
}

void BridgeCall::Deliver(std::string message) {
  delivered_ = true;
  if (cancelled_) return ReadNext();
  listener_.message(std::move(message));
}

void BridgeCall::OnDone(const grpc::Status& status) {
  boost::asio::post(context_, [self = std::move(self_), status] { self->listener_.end(status); });
}

}  // namespace cwm::server
