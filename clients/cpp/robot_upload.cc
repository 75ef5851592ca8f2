#include "clients/cpp/robot_upload.h"

#include <algorithm>
#include <cstdint>

#include "proto/transfer/chunks.h"
#include "proto/transfer/crc32c.h"

namespace cwm::client {
namespace {

namespace pb = cwm::v1;
using Writer = grpc::ClientWriter<pb::LoadRobotRequest>;

// The send functions return false if the server has ended the call; its status then has the reason.
bool SendFile(const RobotFile& file, Writer& writer,
              const std::function<void(std::int64_t sent_bytes)>& sent) {
  const auto total = static_cast<std::int64_t>(file.bytes.size());
  pb::LoadRobotRequest begin;
  begin.mutable_file()->set_name(file.name);
  begin.mutable_file()->set_total_bytes(total);
  if (!writer.Write(begin)) return false;
  for (std::int64_t offset = 0; offset < total; offset += kMaxChunkBytes) {
    pb::LoadRobotRequest request;
    pb::RobotFileChunk& chunk = *request.mutable_chunk();
    chunk.set_offset(offset);
    chunk.set_data(file.bytes.substr(static_cast<std::size_t>(offset), kMaxChunkBytes));
    chunk.set_crc32c(Crc32c(chunk.data()));
    if (!writer.Write(request)) return false;
    sent(static_cast<std::int64_t>(chunk.data().size()));
  }
  return true;
}

bool SendFiles(const std::vector<RobotFile>& files, const Progress& progress, Writer& writer) {
  std::int64_t total = 0, sent = 0;
  for (const RobotFile& file : files) total += static_cast<std::int64_t>(file.bytes.size());
  for (const RobotFile& file : files) {
    const bool goes_on = SendFile(file, writer, [&](std::int64_t bytes) {
      sent += bytes;
      if (progress) progress(sent, total);
    });
    if (!goes_on) return false;
  }
  pb::LoadRobotRequest finish;
  finish.mutable_finish();
  return writer.Write(finish) && writer.WritesDone();
}

}  // namespace

absl::StatusOr<pb::LoadRobotResponse> LoadRobot(const Connection& connection,
                                                const pb::LoadRobotHeader& header,
                                                const std::vector<RobotFile>& files,
                                                const Progress& progress) {
  grpc::ClientContext context;
  connection.Prepare(context);
  pb::LoadRobotResponse response;
  const auto writer = connection.robots().LoadRobot(&context, &response);
  pb::LoadRobotRequest first;
  *first.mutable_header() = header;
  // A failed write has no reason itself: Finish returns the server's.
  if (writer->Write(first)) SendFiles(files, progress, *writer);
  const grpc::Status status = writer->Finish();
  if (!status.ok()) return StatusFromGrpc(status);
  return response;
}

}  // namespace cwm::client
