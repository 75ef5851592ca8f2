#include "clients/cli/progress.h"

#include <cmath>
#include <ostream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/cli/quantity.h"

namespace cwm::cli {
namespace {

constexpr char kEraseLine[] = "\r\033[K";

}  // namespace

std::string FormatTransfer(const Transfer& transfer) {
  const auto moved = static_cast<double>(transfer.moved_bytes);
  const auto total = static_cast<double>(transfer.total_bytes);
  std::string text =
      absl::StrCat(transfer.action, " ", FormatBytes(moved), " of ", FormatBytes(total));
  if (!transfer.detail.empty()) absl::StrAppend(&text, ", ", transfer.detail);
  if (transfer.bytes_per_s <= 0) return text;
  absl::StrAppend(&text, ", ", FormatBytes(transfer.bytes_per_s), "/s, ",
                  FormatFixed(std::ceil((total - moved) / transfer.bytes_per_s), 0), " s left");
  return text;
}

std::string FormatCount(const Transfer& transfer, std::int64_t bytes_each,
                        const std::string& unit) {
  return absl::StrCat(transfer.moved_bytes / bytes_each, " of ", transfer.total_bytes / bytes_each,
                      " ", unit);
}

Progress::Progress(const Session& session)
    : Progress(session.streams.err, session.streams.err_is_terminal ? ProgressStyle::kOneLine
                                                                    : ProgressStyle::kSilent) {}

void Progress::Update(Transfer transfer) {
  const auto now = std::chrono::steady_clock::now();
  if (!start_) start_ = {now, transfer.moved_bytes};
  const std::chrono::duration<double> elapsed = now - start_->time;
  const auto moved = static_cast<double>(transfer.moved_bytes - start_->moved_bytes);
  if (elapsed.count() > 0) transfer.bytes_per_s = moved / elapsed.count();
  ShowStage(FormatTransfer(transfer));
}

void Progress::ShowStage(const std::string& stage) {
  if (style_ == ProgressStyle::kSilent) return;
  err_ << kEraseLine << stage << " ..." << std::flush;
  shown_ = true;
}

void Progress::Clear() {
  if (shown_) err_ << kEraseLine << std::flush;
  shown_ = false;
}

}  // namespace cwm::cli
