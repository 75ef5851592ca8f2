#include "clients/cli/progress.h"

#include <ostream>

#include "absl/strings/str_cat.h"
#include "clients/cli/quantity.h"

namespace cwm::cli {
namespace {

constexpr char kEraseLine[] = "\r\033[K";

}  // namespace

void Progress::Sent(std::int64_t sent_bytes, std::int64_t total_bytes) {
  if (sent_bytes >= total_bytes) return Stage("the server interprets the scan");
  Stage(absl::StrCat("sending ", Bytes(static_cast<double>(sent_bytes)), " of ",
                     Bytes(static_cast<double>(total_bytes))));
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
