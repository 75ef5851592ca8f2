#include "server/store/sqlite/head_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "proto/transfer/crc32c.h"
#include "server/store/store_contract.h"

namespace cwm::server {
namespace {

// Two numbers and the CRC-32C of their 16 bytes, in the byte order of the machine.
constexpr std::size_t kNumbersSize = 2 * sizeof(std::int64_t);
constexpr std::size_t kHeadSize = kNumbersSize + sizeof(std::uint32_t);

std::string EncodeHead(const Head& head) {
  std::string bytes(kHeadSize, '\0');
  std::memcpy(bytes.data(), &head.last, sizeof(head.last));
  std::memcpy(bytes.data() + sizeof(head.last), &head.durable, sizeof(head.durable));
  const std::uint32_t crc = Crc32c(std::string_view(bytes).substr(0, kNumbersSize));
  std::memcpy(bytes.data() + kNumbersSize, &crc, sizeof(crc));
  return bytes;
}

}  // namespace

absl::StatusOr<Head> ReadHead(const std::string& path) {
  absl::StatusOr<std::string> bytes = ReadFile(path);
  if (!bytes.ok()) {
    return StoreDamaged(absl::StrCat(path, ": the file is missing or cannot be read"));
  }
  Head head;
  if (bytes->size() == kHeadSize) {
    std::memcpy(&head.last, bytes->data(), sizeof(head.last));
    std::memcpy(&head.durable, bytes->data() + sizeof(head.last), sizeof(head.durable));
    if (EncodeHead(head) == *bytes) return head;
  }
  return StoreDamaged(absl::StrCat(path, ": its ", bytes->size(), " bytes have another checksum"));
}

absl::StatusOr<HeadFile> HeadFile::Open(const std::string& path) {
  if (FileSize(path) == 0) {
    unlink(path.c_str());
    if (absl::Status status = WriteNewFile(path, EncodeHead({}), true); !status.ok()) return status;
  }
  HeadFile head;
  head.path_ = path;
  head.file_ = FileDescriptor(open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (!head.file_.is_open()) return FileError(path, "cannot be opened", errno);
  return head;
}

absl::Status HeadFile::Write(const Head& head) {
  const std::string bytes = EncodeHead(head);
  if (pwrite(file_.number(), bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size())) {
    return absl::OkStatus();
  }
  return FileError(path_, "cannot be written", errno);
}

absl::Status HeadFile::Sync() {
  if (fdatasync(file_.number()) == 0) return absl::OkStatus();
  return FileError(path_, "cannot be synced", errno);
}

}  // namespace cwm::server
