// Messages of a stream as they come: one that is malformed is told apart from the stream's end. gRPC
// reports both as a read that failed.
#pragma once

#include <grpcpp/grpcpp.h>

#include <cstddef>
#include <string>

namespace cwm::server {

struct ReceivedBytes {
  std::size_t bytes = 0;  // on the wire
  bool is_malformed = false;
};

// What a reactor reads in place of `Message`, by a method that is registered with it.
template <class Message>
struct Received : ReceivedBytes {
  Message message;
};

// The number of a method, e.g. "cwm.v1.PerceptionService.IngestCloud", in its service.
int IndexOfMethod(const std::string& full_name);

}  // namespace cwm::server

namespace grpc {

// Every message is taken: the call says what is wrong with it.
template <class Message>
class SerializationTraits<cwm::server::Received<Message>, void> {
 public:
  static Status Deserialize(ByteBuffer* buffer, cwm::server::Received<Message>* received) {
    received->bytes = buffer->Length();
    received->is_malformed =
        !SerializationTraits<Message>::Deserialize(buffer, &received->message).ok();
    return Status::OK;
  }
};

}  // namespace grpc
