// The services of a server by its own description.
#pragma once

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor_database.h>

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"

namespace cwm::cli {

// Descriptors by gRPC server reflection (v1alpha); the pool requests each file once from the
// server. Not thread safe. The descriptors live as long as the client.
class ReflectionClient {
 public:
  explicit ReflectionClient(const client::Connection& connection);

  // Full names, sorted. UNIMPLEMENTED if the server has no reflection.
  absl::StatusOr<std::vector<std::string>> ListServices();

  // Finds "cwm.v1.WorldService/GetObject", "WorldService/GetObject", "WorldService.GetObject" or,
  // if only one service has it, "GetObject". NOT_FOUND lists the known methods.
  absl::StatusOr<const google::protobuf::MethodDescriptor*> FindMethod(const std::string& name);

  const google::protobuf::DescriptorPool& pool() const { return pool_; }

 private:
  // Requests files when the pool needs them.
  class Database : public google::protobuf::DescriptorDatabase {
   public:
    explicit Database(const client::Connection& connection) : connection_(connection) {}
    bool FindFileByName(const std::string& filename,
                        google::protobuf::FileDescriptorProto* output) override;
    bool FindFileContainingSymbol(const std::string& symbol,
                                  google::protobuf::FileDescriptorProto* output) override;
    bool FindFileContainingExtension(const std::string&, int,
                                     google::protobuf::FileDescriptorProto*) override {
      return false;
    }

   private:
    const client::Connection& connection_;
    google::protobuf::SimpleDescriptorDatabase known_;
  };

  const client::Connection& connection_;
  Database database_;
  google::protobuf::DescriptorPool pool_;
};

}  // namespace cwm::cli
