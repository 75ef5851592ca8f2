#include "server/core/encoded_meshes.h"

#include <iterator>
#include <utility>

namespace cwm::server {
namespace {

std::int64_t Cost(const EncodedMesh& encoded) {
  return static_cast<std::int64_t>(encoded.bytes.size());
}

}  // namespace

std::shared_ptr<const EncodedMesh> EncodedMeshCache::Find(const Source& source) {
  const std::lock_guard lock(mutex_);
  const auto found = by_address_.find(source.get());
  // A reused address belongs to another object: the source that was kept there has died.
  if (found == by_address_.end() || found->second->source.lock() != source) return nullptr;
  recent_.splice(recent_.begin(), recent_, found->second);
  return found->second->encoded;
}

void EncodedMeshCache::Keep(const Source& source, std::shared_ptr<const EncodedMesh> encoded) {
  Entries dropped;  // freed after the lock
  const std::lock_guard lock(mutex_);
  ++made_;
  for (auto entry = recent_.begin(); entry != recent_.end();) {
    const auto here = entry++;
    if (here->address == source.get() || here->source.expired()) Drop(here, dropped);
  }
  held_bytes_ += Cost(*encoded);
  recent_.push_front({source.get(), source, std::move(encoded)});
  by_address_[source.get()] = recent_.begin();
  while (held_bytes_ > max_bytes_ && recent_.size() > 1) Drop(std::prev(recent_.end()), dropped);
}

void EncodedMeshCache::DropExpired() {
  Entries dropped;  // freed after the lock
  const std::lock_guard lock(mutex_);
  for (auto entry = recent_.begin(); entry != recent_.end();) {
    const auto here = entry++;
    if (here->source.expired()) Drop(here, dropped);
  }
}

void EncodedMeshCache::Drop(Entries::iterator entry, Entries& dropped) {
  held_bytes_ -= Cost(*entry->encoded);
  by_address_.erase(entry->address);
  dropped.splice(dropped.end(), recent_, entry);
}

std::int64_t EncodedMeshCache::held_bytes() const {
  const std::lock_guard lock(mutex_);
  return held_bytes_;
}

std::int64_t EncodedMeshCache::made() const {
  const std::lock_guard lock(mutex_);
  return made_;
}

}  // namespace cwm::server
