#include "server/rpc/received.h"

#include <google/protobuf/descriptor.h>

namespace cwm::server {

int IndexOfMethod(const std::string& full_name) {
  return google::protobuf::DescriptorPool::generated_pool()->FindMethodByName(full_name)->index();
}

}  // namespace cwm::server
