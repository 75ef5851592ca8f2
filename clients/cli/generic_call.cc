#include "clients/cli/generic_call.h"

#include <grpcpp/completion_queue.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/slice.h>

namespace cwm::cli {
namespace {

grpc::ByteBuffer ToBuffer(const std::string& bytes) {
  const grpc::Slice slice(bytes);
  return grpc::ByteBuffer(&slice, 1);
}

std::string ToBytes(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  if (!buffer.Dump(&slices).ok()) return {};
  std::string bytes;
  for (const grpc::Slice& slice : slices) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  return bytes;
}

// Waits for the operation that was just started; there is only one at a time.
bool Wait(grpc::CompletionQueue& queue) {
  void* tag = nullptr;
  bool ok = false;
  return queue.Next(&tag, &ok) && ok;
}

}  // namespace

absl::Status CallMethod(const client::Connection& connection, const std::string& path,
                        const std::vector<std::string>& requests,
                        const std::function<void(const std::string&)>& on_reply) {
  grpc::GenericStub stub(connection.channel());
  grpc::ClientContext context;
  connection.Prepare(context);
  grpc::CompletionQueue queue;
  const auto call = stub.PrepareCall(&context, path, &queue);
  call->StartCall(nullptr);
  bool open = Wait(queue);
  for (std::size_t i = 0; open && i < requests.size(); ++i) {
    call->Write(ToBuffer(requests[i]), nullptr);
    open = Wait(queue);
  }
  if (open) {
    call->WritesDone(nullptr);
    Wait(queue);
  }
  // Also after a refused write, since earlier replies must still be read.
  grpc::ByteBuffer reply;
  for (call->Read(&reply, nullptr); Wait(queue); call->Read(&reply, nullptr)) {
    on_reply(ToBytes(reply));
    reply.Clear();
  }
  grpc::Status status;
  call->Finish(&status, nullptr);
  Wait(queue);
  queue.Shutdown();
  void* tag = nullptr;
  bool ok = false;
  while (queue.Next(&tag, &ok)) {
  }
  return client::StatusFromGrpc(status);
}

}  // namespace cwm::cli
