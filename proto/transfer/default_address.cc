#include "proto/transfer/default_address.h"

#include <unistd.h>

#include <cstdlib>

namespace cwm {
namespace {

std::string Environment(const char* name, const std::string& otherwise) {
  const char* const value = std::getenv(name);
  return value != nullptr && *value != '\0' ? value : otherwise;
}

}  // namespace

std::string DefaultAddress() {
  const std::string folder = Environment("XDG_RUNTIME_DIR", "/tmp");
  return Environment("CWM_ADDR", "unix:" + folder + "/cwm-" + std::to_string(getuid()) + ".sock");
}

}  // namespace cwm
