#include "tests/fault/trial.h"

namespace cwm::fault {
namespace {

// chosen: a replay takes a tenth of a second here; ten sanitized servers at a time take longer.
constexpr auto kBootPatience = std::chrono::seconds(30);
constexpr auto kEndPatience = std::chrono::seconds(2);
constexpr auto kFinishPatience = std::chrono::seconds(20);

}  // namespace

Trial::Trial(Campaign& campaign, const WorkloadOptions& options, const std::string& store_directory)
    : campaign_(campaign),
      store_(store_directory.empty() ? scratch_ / "store" : store_directory),
      seed_(options.seed),
      workload_(options) {}

void Trial::Complain(const std::string& text) {
  campaign_.Complain("seed " + std::to_string(seed_) + ": " + text, workload_.recorder().history(),
                     seed_, store_);
}

bool Trial::Boot(std::vector<std::string> environment, bool may_end) {
  environment.insert(environment.end(), environment_.begin(), environment_.end());
  server_.reset();  // ends the one before, if it still runs
  server_ = std::make_unique<ServerProcess>(
      ServerOptions{.program = campaign_.settings().server,
                    .store = campaign_.settings().in_memory ? "" : store_,
                    .directory = scratch_.path(),
                    .environment = environment});
  if (server_->WaitUntilReady(kBootPatience)) return true;
  if (may_end && !server_->Running()) return false;
  is_broken_ = true;
  Complain("restart: the server does not come up: " + server_->LogTail());
  return false;
}

bool Trial::Prepare() {
  if (workload_.Prepare(server_->address())) return true;
  is_broken_ = true;
  Complain("the first write failed: " + server_->LogTail());
  return false;
}

bool Trial::InspectRestart(bool whole, bool may_end) {
  const std::string wrong = workload_.Inspect(server_->address(), whole, /*after_restart=*/true);
  if (wrong.empty()) return true;
  // The connection may be lost before the process is seen to have ended.
  if (may_end && server_->WaitForEnd(kEndPatience)) return false;
  is_broken_ = true;
  Complain("inspection: " + wrong + ": " + server_->LogTail());
  return false;
}

void Trial::Conclude() {
  workload_.Start(server_->address());
  if (!workload_.Finish(kFinishPatience)) {
    Complain("liveness: the clients did not get all answers, or a watch did not reach the end");
  }
  if (const std::string wrong = workload_.Inspect(server_->address(), true, false);
      !wrong.empty()) {
    Complain("inspection: " + wrong);
  }
  if (campaign_.settings().in_memory) return;
  if (const int code = server_->Stop(); code != 0) {
    Complain("the server ended with " + std::to_string(code) +
             " after SIGTERM: " + server_->LogTail());
  }
  if (!Boot() || !InspectRestart(true)) return;
  server_->Kill();
  if (Boot()) InspectRestart(true);
}

void Trial::BackUp() const {
  const client::Connection connection({.address = server_->address()});
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(10));
  const auto reader = connection.admin().BackUp(&context, v1::BackUpRequest());
  v1::BackUpResponse response;
  while (reader->Read(&response)) {
  }
  static_cast<void>(reader->Finish());  // the server may be killed meanwhile
}

void Trial::CheckHistory() {
  const Report before = std::move(report_);
  report_ = Check(workload_.recorder().history());
  campaign_.AddReport(report_, before);
  for (const Violation& violation : report_.violations) {
    Complain(violation.rule + ": " + violation.text);
    is_broken_ = true;
  }
}

}  // namespace cwm::fault
