#include "server/rpc/load_robot_call.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/xml/xml_element.h"
#include "proto/transfer/crc32c.h"
#include "server/core/error.h"
#include "server/rpc/status_conversion.h"
#include "server/wire/numbers.h"

namespace cwm::server {
namespace {

// chosen: the longest path of the file system; a mesh's URI is one with a short prefix.
constexpr std::int64_t kMaxFileNameBytes = 4'096;

// measured: for the meshes of a Panda, text, triangles and their trees take ten times the files'
// bytes.
constexpr std::int64_t kReadingBytes = 4 << 20;
constexpr std::int64_t kReadingBytesPerByte = 10;
// measured: the finest meshes of a Panda, 8.2 MB, are read and prepared within 2 s.
constexpr double kReading_s_per_byte = 0.25e-6;

void AddText(const std::string& text, Sha256& digest) { digest.Add(text.data(), text.size()); }

}  // namespace

absl::Status LoadRobotCall::Take(const v1::LoadRobotRequest& message) {
  if (finished_) return InvalidField("what", "came after finish, nothing may");
  switch (message.what_case()) {
    case v1::LoadRobotRequest::kHeader:
      return TakeHeader(message.header());
    case v1::LoadRobotRequest::kFile:
      return TakeFile(message.file());
    case v1::LoadRobotRequest::kChunk:
      return TakeChunk(message.chunk());
    case v1::LoadRobotRequest::kFinish:
      return TakeFinish();
    case v1::LoadRobotRequest::WHAT_NOT_SET:
      break;
  }
  return InvalidField("what", "is absent, must be one of header, file, chunk, finish");
}

absl::Status LoadRobotCall::TakeHeader(const v1::LoadRobotHeader& header) {
  if (plan_) return InvalidField("header", "came twice, must come once");
  header_ = EmptyCharge();
  auto charged = header_.Resize(static_cast<std::int64_t>(header.ByteSizeLong()));
  if (!charged.ok()) return charged;
  auto plan = RobotPlanFromProto(header, FieldPath::OfRequest("header"));
  if (!plan.ok()) return plan.status();
  plan_ = *std::move(plan);
  v1::LoadRobotHeader content = header;
  content.clear_request_id();
  AddText(content.SerializeAsString(), received_);
  return absl::OkStatus();
}

absl::Status LoadRobotCall::TakeFile(const v1::RobotFile& file) {
  if (!plan_) return InvalidField("file", "came before the header, must come after it");
  const FieldPath root;
  const FieldPath path = root.Field("file");
  if (auto status = CheckFileComplete(path); !status.ok()) return status;
  auto status = CheckTextLength(file.name(), kMaxFileNameBytes, path.Field("name"));
  if (!status.ok()) return status;
  const Limits& limits = runtime_.application.limits;
  if (file.name().empty()) return path.Field("name").Error("is empty, must be given");
  if (file.total_bytes() < 0) return path.Field("total_bytes").Error("is negative, must not be");
  if (file.total_bytes() > limits.max_robot_bytes - total_bytes_) {
    return RobotTooLarge(absl::StrCat("file.total_bytes: the files have more than ",
                                      limits.max_robot_bytes, " bytes together, must have at most ",
                                      "so many (max_robot_bytes)"));
  }
  if (static_cast<std::int64_t>(files_.size()) >= limits.max_robot_files) {
    return RobotTooLarge(absl::StrCat("file: there are more than ", limits.max_robot_files,
                                      ", must be at most so many (max_robot_files)"));
  }
  const auto [entry, is_new] = files_.try_emplace(
      file.name(), Upload(file.total_bytes(), limits.max_chunk_bytes, EmptyCharge()));
  if (!is_new) {
    return path.Field("name").Error(
        absl::StrCat("is ", collision::Quoted(file.name()), ", must come once"));
  }
  current_ = &entry->second;
  total_bytes_ += file.total_bytes();
  AddText(file.SerializeAsString(), received_);
  return absl::OkStatus();
}

absl::Status LoadRobotCall::TakeChunk(const v1::RobotFileChunk& chunk) {
  if (current_ == nullptr) return InvalidField("chunk", "came before a file, must come after one");
  const FieldPath root;
  const FieldPath path = root.Field("chunk");
  if (auto status = current_->Append(chunk.offset(), chunk.data(), path); !status.ok()) {
    return status;
  }
  AddText(chunk.data(), received_);  // hashes while the next chunk is on its way
  const std::uint32_t crc = Crc32c(chunk.data());
  if (crc == chunk.crc32c()) return absl::OkStatus();
  return path.Field("crc32c").Error(absl::StrCat("is ", chunk.crc32c(), " at offset ",
                                                 chunk.offset(), ", must be ", crc,
                                                 " (CRC-32C of data)"));
}

absl::Status LoadRobotCall::TakeFinish() {
  if (!plan_) return InvalidField("finish", "came before the header, must come after it");
  if (auto status = CheckFileComplete(FieldPath::OfRequest("finish")); !status.ok()) return status;
  finished_ = true;
  return absl::OkStatus();
}

absl::Status LoadRobotCall::CheckFileComplete(const FieldPath& path) const {
  return current_ == nullptr ? absl::OkStatus() : current_->CheckComplete(path);
}

absl::Status LoadRobotCall::CheckEnd() const {
  if (!plan_) return InvalidField("header", "is absent, must come first");
  if (!finished_) return InvalidField("finish", "is absent, must come last");
  return absl::OkStatus();
}

double LoadRobotCall::Cost_s() const {
  return kReading_s_per_byte * static_cast<double>(total_bytes_ + header_.bytes());
}

absl::StatusOr<collision::PutRobot> LoadRobotCall::MakePut() {
  const FieldPath root;
  const FieldPath path = root.Field("header");
  std::map<std::string, std::string, std::less<>> bytes;
  for (auto& [name, upload] : files_) bytes.emplace(name, upload.Take());
  auto files = MakeRobotFiles(*plan_, std::move(bytes), path);
  if (!files.ok()) return files.status();
  if (Journal* const journal = runtime_.application.worlds.journal()) {
    auto hash = journal->KeepRobotFiles(*files);
    if (!hash.ok()) return hash.status();
    files->files_hash = *std::move(hash);
  }
  auto robot = ReadRobot(*std::move(files), runtime_.application.limits.robot, call_.stop);
  if (!robot.ok()) return absl::IsCancelled(robot.status()) ? CallCancelled() : robot.status();
  auto put = MakePutRobot(*plan_, *std::move(robot), path);
  if (!put.ok()) return put.status();
  collision::WorldRobot put_robot;  // a watch sends the robot whole
  put_robot.name = put->name;
  put_robot.robot = put->robot;
  put_robot.state = put->state;
  const auto size = static_cast<std::int64_t>(RobotToProto(put_robot).ByteSizeLong());
  const std::int64_t max_bytes = runtime_.application.limits.max_object_bytes;
  if (size <= max_bytes) return put;
  return RobotTooLarge(absl::StrCat("header.urdf: names, joints and groups of the robot have ",
                                    size, " bytes, must have at most ", max_bytes,
                                    " (max_object_bytes)"));
}

absl::Status LoadRobotCall::Work() {
  Application& application = runtime_.application;
  if (!plan_->write.request_id.empty()) plan_->write.request_digest = received_.Hex();
  if (const auto known = application.worlds.Find(plan_->world, plan_->world_uid); known.ok()) {
    // A write that cannot succeed is refused before its files are read.
    if (auto decided = (*known)->Precheck(plan_->write); !decided.ok()) return decided.status();
  }
  // The robot reader bounds the memory it uses by the files' size (robot/prepared_budget.h). The
  // memory of a robot that stays is charged to the world.
  MemoryCharge reading = EmptyCharge();
  auto charged = reading.Resize(kReadingBytes + kReadingBytesPerByte * total_bytes_);
  if (!charged.ok()) return charged;
  auto put = MakePut();
  if (!put.ok()) return put.status();
  files_.clear();  // their bytes were converted to the robot
  if (call_.stop.stop_requested()) return CallCancelled();
  auto lease = application.worlds.AcquireLease(plan_->world, plan_->world_uid);
  if (!lease.ok()) return lease.status();
  auto outcome = LoadRobot(**lease, *put, plan_->write, application.limits);
  if (!outcome.ok()) return outcome.status();
  runtime_.log.RobotLoaded(WorldNameOf(plan_->world), put->name,
                           static_cast<std::int64_t>(put->robot->model->links.size()),
                           outcome->revision.value);
  return Reply(**lease, *outcome, put->name);
}

absl::Status LoadRobotCall::Reply(const World& world, const WriteOutcome& outcome,
                                  const std::string& name) {
  response_.set_world_uid(world.uid());
  response_.set_revision(outcome.revision.value);
  SnapshotPtr snapshot = outcome.snapshot;
  if (outcome.replayed) {
    auto first = world.At(Exactly{outcome.revision}, Clock::now(), call_.stop);
    if (!first.ok()) return absl::OkStatus();  // the revision is no longer kept
    snapshot = *std::move(first);
  }
  const collision::WorldRobotPtr robot = snapshot->FindRobot(name);
  *response_.mutable_robot() = RobotToProto(*robot);
  for (const std::string& warning :
       WarningsOf(*robot->robot, plan_->srdf.has_value(), robot->state)) {
    response_.add_warnings(warning);
  }
  return absl::OkStatus();
}

}  // namespace cwm::server
