// Files that are being read: clients that export the same revision in the same format share one.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/core/memory_budget.h"

namespace cwm::server {

struct ExportedWorld {
  struct Part {
    std::string name;
    std::int64_t byte_count = 0;
  };
  std::string bytes;
  std::vector<std::string> warnings;
  std::vector<Part> files;  // if there are several
  MemoryCharge charge;      // paid by the client that made it
};

// Thread safe. Does not keep files alive.
class ExportedWorlds {
 public:
  // nullptr if nobody is reading it.
  std::shared_ptr<const ExportedWorld> Find(const std::string& key) const {
    const std::lock_guard lock(mutex_);
    const auto found = files_.find(key);
    return found == files_.end() ? nullptr : found->second.lock();
  }
  // Returns the file, or the same file that another call made meanwhile.
  std::shared_ptr<const ExportedWorld> Keep(const std::string& key,
                                            std::shared_ptr<const ExportedWorld> file) {
    const std::lock_guard lock(mutex_);
    std::erase_if(files_, [](const auto& entry) { return entry.second.expired(); });
    std::weak_ptr<const ExportedWorld>& kept = files_[key];
    if (auto other = kept.lock()) return other;
    kept = file;
    return file;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::weak_ptr<const ExportedWorld>> files_;
};

}  // namespace cwm::server
