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

std::string TransferText(const Transfer& transfer) {
  const auto moved = static_cast<double>(transfer.moved_bytes);
  const auto total = static_cast<double>(transfer.total_bytes);
  std::string text = absl::StrCat(transfer.doing, " ", Bytes(moved), " of ", Bytes(total));
  if (!transfer.of_what.empty()) absl::StrAppend(&text, ", ", transfer.of_what);
  if (transfer.bytes_per_s <= 0) return text;
  absl::StrAppend(&text, ", ", Bytes(transfer.bytes_per_s), "/s, ",
                  Fixed(std::ceil((total - moved) / transfer.bytes_per_s), 0), " s left");
  return text;
}

std::string CountText(const Transfer& transfer, std::int64_t bytes_each,
                      const std::string& things) {
  return absl::StrCat(transfer.moved_bytes / bytes_each, " of ", transfer.total_bytes / bytes_each,
                      " ", things);
}

Progress::Progress(const Session& session)
    : Progress(session.streams.err, session.streams.err_is_terminal ? ProgressStyle::kOneLine
                                                                    : ProgressStyle::kSilent) {}

void Progress::Moved(Transfer transfer) {
  const auto now = std::chrono::steady_clock::now();
  if (!first_) first_ = {now, transfer.moved_bytes};
  const std::chrono::duration<double> elapsed = now - first_->when;
  const auto moved = static_cast<double>(transfer.moved_bytes - first_->moved_bytes);
  if (elapsed.count() > 0) transfer.bytes_per_s = moved / elapsed.count();
  Stage(TransferText(transfer));
}

void Progress::Stage(const std::string& stage) {
  if (style_ == ProgressStyle::kSilent) return;
  err_ << kEraseLine << stage << " ..." << std::flush;
  shown_ = true;
}

void Progress::Clear() {
  if (shown_) err_ << kEraseLine << std::flush;
  shown_ = false;
}

}  // namespace cwm::cli
