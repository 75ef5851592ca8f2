#include "server/rpc/upload.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace cwm::server {
namespace {

// chosen: growing the buffer copies it, on a thread that all calls share: 10 ms for so many bytes.
// A client that has sent so many gets the full buffer at once; untouched pages cost nothing.
constexpr std::size_t kMaxGrownBytes = std::size_t{16} << 20;

}  // namespace

std::size_t Upload::NextCapacity() const {
  const auto total = static_cast<std::size_t>(total_bytes_);
  if (bytes_.size() >= kMaxGrownBytes) return total;
  return std::min(total, 2 * (bytes_.size() + static_cast<std::size_t>(max_chunk_bytes_)));
}

absl::Status Upload::Append(std::int64_t offset, const std::string& data, const FieldPath& path) {
  const auto size = static_cast<std::int64_t>(data.size());
  const auto received = static_cast<std::int64_t>(bytes_.size());
  if (size == 0 || size > max_chunk_bytes_) {
    return path.Field("data").Error(
        absl::StrCat("has ", size, " bytes, must have 1 to ", max_chunk_bytes_));
  }
  if (offset != received) {
    const char* const what = offset < received ? "came before" : "leaves a gap";
    return path.Field("offset").Error(absl::StrCat("is ", offset, " (", what, "), must be ",
                                                   received, ": chunks come once and in order"));
  }
  if (size > total_bytes_ - received) {
    return path.Field("data").Error(absl::StrCat("goes to byte ", received + size,
                                                 ", must end at total_bytes (", total_bytes_, ")"));
  }
  if (absl::Status charged = charge_.Resize(received + size); !charged.ok()) return charged;
  if (bytes_.capacity() < bytes_.size() + data.size()) bytes_.reserve(NextCapacity());
  bytes_ += data;
  return absl::OkStatus();
}

absl::Status Upload::CheckComplete(const FieldPath& path) const {
  const auto received = static_cast<std::int64_t>(bytes_.size());
  if (received == total_bytes_) return absl::OkStatus();
  return path.Error(absl::StrCat("came after ", received, " bytes, must come after all ",
                                 total_bytes_, " that were announced"));
}

}  // namespace cwm::server
