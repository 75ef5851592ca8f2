// Checks folders in which no other user can have put a socket, so that a server that listens there
// and a client that dials there meet no other user.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace cwm {

enum class FolderRule {
  kPrivate,   // belongs to this user and gives group and others no permission
  kUnshared,  // belongs to this user or to root, and group and others cannot write to it
};

// Returns Ok for a directory that satisfies the rule; root and this user can still change it.
// PermissionDenied names the path, what is wrong (owner, mode, a symbolic link) and the rule.
// NotFound if the path does not exist. Thread-safe.
absl::Status CheckFolder(const std::string& path, FolderRule rule);

// Creates the directory with mode 0700 if it does not exist, then checks it as kPrivate.
absl::Status MakePrivateFolder(const std::string& path);

}  // namespace cwm
