#include "server/rpc/ingest_call.h"

#include <atomic>
#include <memory>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "proto/transfer/crc32c.h"
#include "proto/transfer/sha256.h"
#include "server/core/error.h"
#include "server/rpc/status_conversion.h"

namespace cwm::server {
namespace {

// measured: clouds of 0.3 to 15 million points take 0.4 us and 75 bytes per point at the peak.
constexpr double kInterpreting_s_per_point = 0.5e-6;
constexpr std::int64_t kInterpretingBytesPerPoint = 80;

absl::Status OutOfTime() {
  return MakeError(
      absl::StatusCode::kDeadlineExceeded,
      "header.time_budget or 0.9 of the deadline was spent before the cloud was understood",
      {.reason = "TIME_BUDGET_SPENT", .fields = {}, .metadata = {}, .retry_after_s = {}});
}

// A retry has the same digest: of everything that the client sent except the request_id.
std::string DigestOf(v1::IngestCloudHeader header, const std::string& sha256_of_bytes) {
  header.clear_request_id();
  return Sha256Hex(header.SerializeAsString() + sha256_of_bytes);
}

// Requests the stop when the time budget is spent, and remembers it.
class BudgetGuard {
 public:
  BudgetGuard(Timer& timer, std::optional<Clock::time_point> give_up_at, std::stop_source stop)
      : spent_(std::make_shared<std::atomic<bool>>(false)) {
    if (!give_up_at) return;
    timer.After(*give_up_at - Clock::now(), [spent = spent_, stop]() mutable {
      *spent = true;
      stop.request_stop();
    });
  }
  bool spent() const { return *spent_; }

 private:
  std::shared_ptr<std::atomic<bool>> spent_;
};

}  // namespace

absl::Status IngestCall::Take(const v1::IngestCloudRequest& message) {
  if (finished_) return InvalidField("what", "came after finish, nothing may");
  switch (message.what_case()) {
    case v1::IngestCloudRequest::kHeader:
      return TakeHeader(message.header());
    case v1::IngestCloudRequest::kChunk:
      return TakeChunk(message.chunk());
    case v1::IngestCloudRequest::kFinish:
      return TakeFinish(message.finish());
    case v1::IngestCloudRequest::WHAT_NOT_SET:
      break;
  }
  return InvalidField("what", "is absent, must be one of header, chunk, finish");
}

absl::Status IngestCall::TakeHeader(const v1::IngestCloudHeader& header) {
  if (plan_) return InvalidField("header", "came twice, must come once");
  auto plan =
      CloudPlanFromProto(header, runtime_.application.limits, FieldPath::OfRequest("header"));
  if (!plan.ok()) return plan.status();
  const std::int64_t max_bytes = runtime_.application.limits.max_cloud_bytes;
  if (plan->total_bytes > max_bytes) {
    return InvalidField("header.total_bytes",
                        absl::StrCat("is ", plan->total_bytes, ", must be at most ", max_bytes));
  }
  header_ = header;
  plan_ = *std::move(plan);
  upload_.emplace(plan_->total_bytes, runtime_.application.limits.max_chunk_bytes, EmptyCharge());
  return absl::OkStatus();
}

absl::Status IngestCall::TakeChunk(const v1::CloudChunk& chunk) {
  if (!plan_) return InvalidField("chunk", "came before the header, must come after it");
  const FieldPath root;
  const FieldPath path = root.Field("chunk");
  if (auto status = upload_->Append(chunk.offset(), chunk.data(), path); !status.ok()) {
    return status;
  }
  received_.Add(chunk.data().data(), chunk.data().size());  // while the next one is received
  const std::uint32_t crc = Crc32c(chunk.data());
  if (crc == chunk.crc32c()) return absl::OkStatus();
  return path.Field("crc32c").Error(absl::StrCat("is ", chunk.crc32c(), " at offset ",
                                                 chunk.offset(), ", must be ", crc,
                                                 " (CRC-32C of data)"));
}

absl::Status IngestCall::TakeFinish(const v1::CloudFinish& finish) {
  const FieldPath root;
  if (!plan_) return root.Field("finish").Error("came before the header, must come after it");
  if (auto status = upload_->CheckComplete(root.Field("finish")); !status.ok()) return status;
  sha256_ = absl::AsciiStrToLower(finish.sha256());
  finished_ = true;
  return absl::OkStatus();
}

absl::Status IngestCall::CheckEnd() const {
  if (!plan_) return InvalidField("header", "is absent, must come first");
  if (!finished_) {
    return InvalidField("finish", absl::StrCat("is absent after ", upload_->bytes().size(),
                                               " bytes, must come last"));
  }
  return absl::OkStatus();
}

double IngestCall::Cost_s() const {
  return kInterpreting_s_per_point * static_cast<double>(plan_->point_count);
}

absl::StatusOr<IngestRequest> IngestCall::MakeRequest() {
  const std::string& bytes = upload_->bytes();
  const std::string actual = received_.Hex();
  if (!sha256_.empty() && actual != sha256_) {
    return InvalidField("finish.sha256", absl::StrCat("is ", sha256_, ", must be ", actual,
                                                      " (SHA-256 of all bytes)"));
  }
  IngestRequest request = plan_->request;
  if (!request.write.request_id.empty()) request.write.request_digest = DigestOf(header_, actual);
  auto decoded = DecodeCloud(*plan_, bytes);
  if (!decoded.ok()) return decoded.status();
  request.cloud = std::move(decoded->cloud);
  request.viewpoint_C = decoded->viewpoint_C;
  return request;
}

// Keeps the scan for display. If it does not fit, there is nothing to display, but the ingest is
// unaffected. The scan of an unchanged view looks like the kept one.
void IngestCall::KeepScan(World& world, const IngestRequest& request,
                          const IngestOutcome& outcome) {
  if (outcome.replayed) return;
  if (outcome.unchanged_view &&
      world.scans().Renew(request.sensor, outcome.revision, request.taken_at())) {
    return;
  }
  Application& application = runtime_.application;
  auto scan = MakeKeptScan(request, outcome, application.limits, application.geometry);
  if (scan.ok()) world.scans().Keep(*std::move(scan), application.limits.max_kept_scans);
}

absl::Status IngestCall::Work() {
  line_.outcome = Interpret();
  line_.world = WorldNameOf(plan_->world);
  line_.sensor = plan_->request.sensor;
  line_.took = Clock::now() - begin_;
  runtime_.log.Ingested(line_);
  return line_.outcome;
}

absl::Status IngestCall::Interpret() {
  work_ = EmptyCharge();
  auto charged = work_.Resize(kInterpretingBytesPerPoint * plan_->point_count);
  if (!charged.ok()) return charged;
  Application& application = runtime_.application;
  const Clock::time_point received = Clock::now();
  auto request = MakeRequest();
  if (!request.ok()) return request.status();
  upload_.reset();  // its bytes were converted to the cloud
  const Clock::time_point decoded = Clock::now();
  line_.points = static_cast<std::int64_t>(request->cloud.points.size());
  auto lease = application.worlds.AcquireLease(plan_->world, plan_->world_uid);
  if (!lease.ok()) return lease.status();
  request->options.max_threads = runtime_.cores;
  request->options.threads_now = [this] { return runtime_.ThreadsForScan(); };
  const BudgetGuard budget(runtime_.timer, AnswerDeadline(plan_->time_budget, call_.deadline),
                           stop_);
  auto outcome = Ingest(**lease, *request, application.interpret, call_.stop);
  if (!outcome.ok()) {
    return absl::IsCancelled(outcome.status()) && budget.spent() ? OutOfTime() : outcome.status();
  }
  if (!outcome->replayed) {
    const auto milliseconds = [](Clock::duration time) {
      return std::chrono::duration<double, std::milli>(time).count();
    };
    std::vector<perception::StageTime>& stages = outcome->report.stages;
    stages.insert(stages.begin(), {{"receive", milliseconds(received - begin_)},
                                   {"decode", milliseconds(decoded - received)}});
  }
  line_.objects = static_cast<std::int64_t>(outcome->objects.size());
  line_.revision = outcome->revision.value;
  if (request->mode != IngestMode::kSegmentOnly) {
    KeepScan(**lease, *request, *outcome);
  }
  auto status = IngestReplyToProto({*outcome, **lease, plan_->want_point_labels},
                                   application.limits, application.geometry, &response_);
  if (!lease->committed()) response_.clear_world_uid();
  return status;
}

}  // namespace cwm::server
