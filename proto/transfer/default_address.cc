#include "proto/transfer/default_address.h"

#include <unistd.h>

#include <cstdlib>

#include "absl/strings/str_cat.h"
#include "proto/transfer/private_folder.h"

namespace cwm {
namespace {

constexpr char kWaysOut[] =
    "; another user could answer there: choose an address with CWM_ADDR, --listen (server) or "
    "--addr "
    "(client), or set XDG_RUNTIME_DIR to a directory of your own";

std::string Environment(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

std::string FolderInTmp() { return absl::StrCat("/tmp/cwm-", getuid()); }

}  // namespace

std::string DefaultAddress() {
  if (std::string chosen = Environment("CWM_ADDR"); !chosen.empty()) return chosen;
  const std::string folder = Environment("XDG_RUNTIME_DIR");
  if (folder.empty()) return absl::StrCat("unix:", FolderInTmp(), "/cwm.sock");
  return absl::StrCat("unix:", folder, "/cwm-", getuid(), ".sock");
}

absl::Status PrepareDefaultAddress() {
  if (!Environment("CWM_ADDR").empty()) return absl::OkStatus();
  const std::string folder = Environment("XDG_RUNTIME_DIR");
  const absl::Status status = folder.empty() ? MakePrivateFolder(FolderInTmp())
                                             : CheckFolder(folder, FolderRule::kUnshared);
  if (status.ok()) return status;
  const std::string message =
      absl::StrCat(folder.empty() ? "" : "XDG_RUNTIME_DIR: ", status.message());
  if (absl::IsNotFound(status)) return absl::UnavailableError(message);
  return absl::PermissionDeniedError(absl::StrCat(message, kWaysOut));
}

}  // namespace cwm
