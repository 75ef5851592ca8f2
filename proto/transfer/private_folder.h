// Folders in which no other user can have put a socket: a server that listens there, and a client
// that dials there, meet nobody else.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace cwm {

enum class FolderRule {
  kPrivate,   // belongs to this user and gives group and others no permission
  kUnshared,  // belongs to this user or to root, and group and others cannot write to it
};

// Ok for a directory that keeps the rule; root and this user can still change it. PermissionDenied
// names the path, what is wrong (owner, mode, a symbolic link) and the rule. NotFound when nothing
// is there. Thread-safe.
absl::Status CheckFolder(const std::string& path, FolderRule rule);

// Makes the directory with mode 0700 when nothing is there, then checks it as kPrivate.
absl::Status MakePrivateFolder(const std::string& path);

}  // namespace cwm
