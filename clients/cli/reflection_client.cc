#include "clients/cli/reflection_client.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cli/proto/reflection.grpc.pb.h"

namespace cwm::cli {
namespace {

namespace reflection = grpc::reflection::v1alpha;
using google::protobuf::FileDescriptorProto;
using google::protobuf::MethodDescriptor;
using google::protobuf::ServiceDescriptor;

absl::StatusOr<reflection::ServerReflectionResponse> SendRequest(
    const client::Connection& connection, const reflection::ServerReflectionRequest& request) {
  const auto stub = reflection::ServerReflection::NewStub(connection.channel());
  grpc::ClientContext context;
  connection.Prepare(context);
  const auto stream = stub->ServerReflectionInfo(&context);
  reflection::ServerReflectionResponse response;
  stream->Write(request);
  stream->WritesDone();
  const bool answered = stream->Read(&response);
  if (const grpc::Status status = stream->Finish(); !status.ok())
    return client::StatusFromGrpc(status);
  if (!answered) return absl::InternalError("server reflection did not answer");
  if (response.has_error_response()) {
    return absl::NotFoundError(response.error_response().error_message());
  }
  return response;
}

// Splits at the last '/' or '.': {"cwm.v1.WorldService", "GetObject"}; the service is empty if
// there is none.
std::pair<std::string, std::string> SplitMethod(const std::string& name) {
  const std::size_t at = name.find_last_of("/.");
  if (at == std::string::npos) return {"", name};
  return {name.substr(0, at), name.substr(at + 1)};
}

// True if `full` is `name` or ends in ".name"; an empty name matches all.
bool Names(const std::string& name, const std::string& full) {
  if (name.empty() || name == full) return true;
  const std::string ending = "." + name;
  return full.size() > ending.size() &&
         full.compare(full.size() - ending.size(), ending.size(), ending) == 0;
}

}  // namespace

bool ReflectionClient::Database::FindFileByName(const std::string& filename,
                                                FileDescriptorProto* output) {
  if (known_.FindFileByName(filename, output)) return true;
  reflection::ServerReflectionRequest request;
  request.set_file_by_filename(filename);
  const auto response = SendRequest(connection_, request);
  if (!response.ok()) return false;
  for (const std::string& bytes : response->file_descriptor_response().file_descriptor_proto()) {
    FileDescriptorProto file;
    FileDescriptorProto known;
    if (file.ParseFromString(bytes) && !known_.FindFileByName(file.name(), &known))
      known_.Add(file);
  }
  return known_.FindFileByName(filename, output);
}

bool ReflectionClient::Database::FindFileContainingSymbol(const std::string& symbol,
                                                          FileDescriptorProto* output) {
  reflection::ServerReflectionRequest request;
  request.set_file_containing_symbol(symbol);
  const auto response = SendRequest(connection_, request);
  if (!response.ok() || response->file_descriptor_response().file_descriptor_proto().empty()) {
    return false;
  }
  // The file that defines the symbol comes first, followed by its imports.
  FileDescriptorProto file;
  return file.ParseFromString(response->file_descriptor_response().file_descriptor_proto(0)) &&
         FindFileByName(file.name(), output);
}

ReflectionClient::ReflectionClient(const client::Connection& connection)
    : connection_(connection), database_(connection), pool_(&database_) {}

absl::StatusOr<std::vector<std::string>> ReflectionClient::ListServices() {
  reflection::ServerReflectionRequest request;
  request.set_list_services("*");
  const auto response = SendRequest(connection_, request);
  if (!response.ok()) return response.status();
  std::vector<std::string> names;
  for (const auto& service : response->list_services_response().service()) {
    names.push_back(service.name());
  }
  std::sort(names.begin(), names.end());
  return names;
}

absl::StatusOr<const MethodDescriptor*> ReflectionClient::FindMethod(const std::string& name) {
  const auto services = ListServices();
  if (!services.ok()) return services.status();
  const auto [service_name, method_name] = SplitMethod(name);
  std::vector<const MethodDescriptor*> found;
  std::vector<std::string> known;
  for (const std::string& full : *services) {
    if (!Names(service_name, full)) continue;
    const ServiceDescriptor* service = pool_.FindServiceByName(full);
    if (service == nullptr) {  // gRPC serves health without a descriptor
      service = google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(full);
    }
    if (service == nullptr) continue;
    for (int i = 0; i < service->method_count(); ++i) {
      known.push_back(absl::StrCat(full, "/", service->method(i)->name()));
      if (service->method(i)->name() == method_name) found.push_back(service->method(i));
    }
  }
  if (found.size() == 1) return found.front();
  if (known.empty()) known = *services;
  return absl::NotFoundError(absl::StrCat("method ", name,
                                          found.empty() ? " is unknown" : " is ambiguous",
                                          "; there are ", absl::StrJoin(known, ", ")));
}

}  // namespace cwm::cli
