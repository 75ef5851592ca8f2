#include "server/store/sqlite/ballast.h"

#include <fcntl.h>
#include <unistd.h>

#include <utility>

#include "server/store/sqlite/store_files.h"

namespace cwm::server {

Ballast::Ballast(std::string path, std::int64_t bytes)
    : path_(std::move(path)), bytes_(bytes), exists_(bytes > 0 && FileSize(path_) == bytes) {}

void Ballast::Remove() {
  unlink(path_.c_str());
  exists_ = false;
}

void Ballast::Restore() {
  if (exists_ || bytes_ == 0) return;
  const FileDescriptor file(open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
  exists_ = file.is_open() && posix_fallocate(file.number(), 0, bytes_) == 0;
  if (!exists_) Remove();
}

}  // namespace cwm::server
