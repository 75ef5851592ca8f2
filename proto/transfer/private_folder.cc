#include "proto/transfer/private_folder.h"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "absl/strings/str_cat.h"

namespace cwm {
namespace {

constexpr mode_t kPermissions = 07777;
constexpr mode_t kGroupAndOthers = S_IRWXG | S_IRWXO;
constexpr mode_t kWritableByOthers = S_IWGRP | S_IWOTH;

std::string Octal(mode_t mode) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "%04o", mode & kPermissions);
  return text.data();
}

// lstat follows a symbolic link whose name ends with a slash.
std::string WithoutSlashes(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

std::string FaultOf(const struct stat& info, FolderRule rule) {
  if (S_ISLNK(info.st_mode)) return "is a symbolic link, must be a directory";
  if (!S_ISDIR(info.st_mode)) return "is no directory, must be one";
  const uid_t user = getuid();
  const bool is_private = rule == FolderRule::kPrivate;
  if (info.st_uid != user && (is_private || info.st_uid != 0)) {
    return absl::StrCat("belongs to user ", info.st_uid, ", must belong to user ", user,
                        is_private ? "" : " or root");
  }
  if (is_private && (info.st_mode & kGroupAndOthers) != 0) {
    return absl::StrCat("has mode ", Octal(info.st_mode), ", must have 0700");
  }
  if (!is_private && (info.st_mode & kWritableByOthers) != 0) {
    return absl::StrCat("has mode ", Octal(info.st_mode),
                        ", must not be writable by its group or others");
  }
  return {};
}

}  // namespace

absl::Status CheckFolder(const std::string& path, FolderRule rule) {
  struct stat info {};
  if (lstat(WithoutSlashes(path).c_str(), &info) != 0) {
    const std::string message = absl::StrCat(path, ": ", std::strerror(errno));
    return errno == ENOENT ? absl::NotFoundError(message) : absl::PermissionDeniedError(message);
  }
  const std::string fault = FaultOf(info, rule);
  if (fault.empty()) return absl::OkStatus();
  return absl::PermissionDeniedError(absl::StrCat(path, ": ", fault));
}

absl::Status MakePrivateFolder(const std::string& path) {
  if (mkdir(path.c_str(), S_IRWXU) != 0 && errno != EEXIST) {
    return absl::PermissionDeniedError(
        absl::StrCat(path, ": cannot be made: ", std::strerror(errno)));
  }
  return CheckFolder(path, FolderRule::kPrivate);
}

}  // namespace cwm
