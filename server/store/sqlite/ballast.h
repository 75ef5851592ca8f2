// Room that is kept for the work that frees room: SQLite cannot even delete on a full disk.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

namespace cwm::server {

class Ballast {
 public:
  Ballast(std::string path, std::int64_t bytes);

  bool exists() const { return exists_; }  // thread safe
  std::int64_t bytes() const { return bytes_; }
  void Remove();
  // Allocates the file; without room it stays away.
  void Restore();

 private:
  const std::string path_;
  const std::int64_t bytes_;
  std::atomic<bool> exists_ = false;
};

}  // namespace cwm::server
