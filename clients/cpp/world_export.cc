#include "clients/cpp/world_export.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace cwm::client {

namespace pb = cwm::v1;

namespace {

bool IsSafeRelativePath(const std::string& name) {
  for (const absl::string_view part : absl::StrSplit(name, '/')) {
    if (part.empty() || part == "." || part == "..") return false;
  }
  return true;
}

// Splits the files after the first off the bytes.
absl::Status Divide(const google::protobuf::RepeatedPtrField<pb::ExportedFile>& files,
                    ExportedWorld& exported) {
  if (files.empty()) return absl::OkStatus();
  std::size_t begin = 0;
  for (const pb::ExportedFile& file : files) {
    const std::size_t left = exported.bytes.size() - begin;
    if (file.byte_count() < 0 || static_cast<std::uint64_t>(file.byte_count()) > left) {
      return absl::DataLossError(absl::StrCat("file \"", file.name(), "\" has ", file.byte_count(),
                                              " bytes, ", left, " are left of the export"));
    }
    const auto count = static_cast<std::size_t>(file.byte_count());
    if (&file != &files.Get(0)) {
      if (!IsSafeRelativePath(file.name())) {
        return absl::DataLossError(
            absl::StrCat("file \"", file.name(), "\" is not below the first"));
      }
      exported.files.push_back({file.name(), exported.bytes.substr(begin, count)});
    }
    begin += count;
  }
  exported.bytes.resize(static_cast<std::size_t>(files.Get(0).byte_count()));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ExportedWorld> ExportWorld(const Connection& connection,
                                          const pb::ExportWorldRequest& request,
                                          const Progress& progress) {
  grpc::ClientContext context;
  connection.Prepare(context);
  const auto reader = connection.worlds().ExportWorld(&context, request);
  ExportedWorld exported;
  pb::ExportWorldResponse chunk;
  google::protobuf::RepeatedPtrField<pb::ExportedFile> files;
  while (reader->Read(&chunk)) {
    if (chunk.offset() == 0) files = chunk.files();
    exported.bytes += chunk.data();
    if (progress) progress(static_cast<std::int64_t>(exported.bytes.size()), chunk.total_bytes());
  }
  if (const grpc::Status status = reader->Finish(); !status.ok()) return StatusFromGrpc(status);
  if (!chunk.done() || static_cast<std::int64_t>(exported.bytes.size()) != chunk.total_bytes()) {
    return absl::DataLossError(absl::StrCat("the export has ", chunk.total_bytes(), " bytes, ",
                                            exported.bytes.size(), " arrived"));
  }
  exported.world_uid = chunk.world_uid();
  exported.revision = chunk.revision();
  exported.warnings.assign(chunk.warnings().begin(), chunk.warnings().end());
  if (absl::Status divided = Divide(files, exported); !divided.ok()) return divided;
  return exported;
}

}  // namespace cwm::client
