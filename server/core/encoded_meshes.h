// A cache of encoded meshes, so that a client that reads a mesh in ranges, or several clients that
// read the same mesh, have it encoded once.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

namespace cwm::server {

struct EncodedMesh {
  std::string bytes;           // encoded as in mesh_bytes.h
  std::string hash;            // SHA-256 of the bytes
  double max_deviation_m = 0;  // of a full surface (full_surface.h)
};

// Thread safe. Keeps the most recently used encodings within a byte limit; a single one may exceed
// it.
class EncodedMeshCache {
 public:
  explicit EncodedMeshCache(std::int64_t max_bytes) : max_bytes_(max_bytes) {}

  // The object that an encoding was made from, identified by its address while it lives.
  using Source = std::shared_ptr<const void>;

  // nullptr if no encoding is kept.
  std::shared_ptr<const EncodedMesh> Find(const Source& source);
  // Replaces the source's encoding, and drops the encodings of sources that died.
  void Keep(const Source& source, std::shared_ptr<const EncodedMesh> encoded);

  // Drops the encodings of sources that died.
  void DropExpired();

  std::int64_t held_bytes() const;
  // Number of encodings made, which is the number of calls of Keep.
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
