#include "clients/cli/progress.h"

#include <cmath>
#include <ostream>

#include "absl/strings/str_cat.h"
#include "clients/cli/quantity.h"

namespace cwm::cli {
namespace {

constexpr char kEraseLine[] = "\r\033[K";

}  // namespace

std::string UploadText(const Upload& upload) {
  const auto sent = static_cast<double>(upload.sent_bytes);
  const auto total = static_cast<double>(upload.total_bytes);
  std::string text = absl::StrCat("sending ", Bytes(sent), " of ", Bytes(total), ", ",
                                  upload.sent_bytes / upload.point_bytes, " of ",
                                  upload.total_bytes / upload.point_bytes, " points");
  if (upload.elapsed_s <= 0 || upload.sent_bytes <= 0) return text;
  const double rate = sent / upload.elapsed_s;
  absl::StrAppend(&text, ", ", Bytes(rate), "/s, ", Fixed(std::ceil((total - sent) / rate), 0),
                  " s left");
  return text;
}

void Progress::Sent(Upload upload) {
  if (upload.sent_bytes >= upload.total_bytes) {
    return Stage(
        absl::StrCat("the server interprets ", upload.total_bytes / upload.point_bytes, " points"));
  }
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  upload.elapsed_s = elapsed.count();
  Stage(UploadText(upload));
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
