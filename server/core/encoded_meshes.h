// Meshes as they travel, kept for a while: a client that reads a mesh in ranges, or several that
// read the same, have it encoded once.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

namespace cwm::server {

struct EncodedMesh {
  std::string bytes;           // as in mesh_bytes.h
  std::string hash;            // SHA-256 of the bytes
  double max_deviation_m = 0;  // of a full surface (full_surface.h)
};

// Thread safe. The encodings that were used last, within a byte limit; one alone may exceed it.
class EncodedMeshes {
 public:
  explicit EncodedMeshes(std::int64_t max_bytes) : max_bytes_(max_bytes) {}

  // What an encoding was made from; known by its address, and only while it lives.
  using Source = std::shared_ptr<const void>;

  // nullptr when none is kept.
  std::shared_ptr<const EncodedMesh> Find(const Source& source);
  // Replaces. Lets go of those whose source died.
  void Keep(const Source& source, std::shared_ptr<const EncodedMesh> encoded);

  // Lets go of those whose source died.
  void ForgetDead();

  std::int64_t held_bytes() const;
  // How many were made: counted by Keep.
  std::int64_t made() const;

 private:
  struct Entry {
    const void* address = nullptr;
    std::weak_ptr<const void> source;
    std::shared_ptr<const EncodedMesh> encoded;
  };
  using Entries = std::list<Entry>;

  void Drop(Entries::iterator entry, Entries& dropped);

  const std::int64_t max_bytes_;
  mutable std::mutex mutex_;
  Entries recent_;  // newest first
  std::unordered_map<const void*, Entries::iterator> by_address_;
  std::int64_t held_bytes_ = 0;
  std::int64_t made_ = 0;
};

}  // namespace cwm::server
