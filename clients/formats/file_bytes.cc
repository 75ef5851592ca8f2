#include "clients/formats/file_bytes.h"

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "absl/strings/str_cat.h"

namespace cwm::formats {
namespace {

absl::Status SystemError(const std::string& path, const std::string& action,
                         const std::error_code& error) {
  const std::string message = absl::StrCat(path, ": cannot ", action, ": ", error.message());
  if (error == std::errc::permission_denied || error == std::errc::read_only_file_system) {
    return absl::PermissionDeniedError(message);
  }
  if (error == std::errc::no_space_on_device) return absl::ResourceExhaustedError(message);
  return absl::InvalidArgumentError(message);
}

std::error_code LastError() { return {errno == 0 ? EIO : errno, std::generic_category()}; }

}  // namespace

absl::StatusOr<std::string> ReadFileBytes(const std::string& path, std::int64_t max_bytes) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    return SystemError(path, "read", std::make_error_code(std::errc::no_such_file_or_directory));
  }
  if (!std::filesystem::is_regular_file(status)) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": not a regular file"));
  }
  const auto size = static_cast<std::int64_t>(std::filesystem::file_size(path, error));
  if (error) return SystemError(path, "read", error);
  if (size > max_bytes) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": size is ", size, " bytes, must be at most ", max_bytes));
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) return SystemError(path, "open", LastError());
  std::string bytes(static_cast<std::size_t>(size), '\0');
  if (!file.read(bytes.data(), size)) return SystemError(path, "read", LastError());
  return bytes;
}

absl::Status WriteFileBytes(const std::string& path, std::string_view bytes) {
  const std::string beside = absl::StrCat(path, ".", ::getpid(), ".part");
  errno = 0;
  std::ofstream file(beside, std::ios::binary | std::ios::trunc);
  if (!file) return SystemError(path, "write", LastError());
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  std::error_code error = file ? std::error_code() : LastError();
  if (!error) std::filesystem::rename(beside, path, error);
  if (!error) return absl::OkStatus();
  std::error_code ignored;
  std::filesystem::remove(beside, ignored);
  return SystemError(path, "write", error);
}

}  // namespace cwm::formats
