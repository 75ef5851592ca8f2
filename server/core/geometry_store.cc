#include "server/core/geometry_store.h"

#include <algorithm>
#include <cstring>
#include <deque>
#include <list>
#include <mutex>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/geometry/validation.h"
#include "collision/world/full_surface.h"
#include "proto/transfer/sha256.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

std::string HashOfEncoding(const TriangleMesh& mesh) {
  Sha256 sha;
  ForEachMeshPiece(mesh, [&](const void* data, std::size_t size) { sha.Add(data, size); });
  return sha.Hex();
}

// Hashes of living meshes by address. An entry is valid while its weak pointer still leads to the
// mesh, so a reused address does not hit.
class HashCache {
 public:
  std::string Find(const std::shared_ptr<const TriangleMesh>& mesh) {
    std::lock_guard lock(mutex_);
    const auto found = entries_.find(mesh.get());
    if (found == entries_.end() || found->second.mesh.lock() != mesh) return {};
    return found->second.hash;
  }

  void Keep(const std::shared_ptr<const TriangleMesh>& mesh, const std::string& hash) {
    std::lock_guard lock(mutex_);
    if (entries_.size() >= purge_at_) {
      std::erase_if(entries_, [](const auto& entry) { return entry.second.mesh.expired(); });
      purge_at_ = 2 * entries_.size() + kFirstPurge;  // amortised: one check per insertion
    }
    entries_[mesh.get()] = {mesh, hash};
  }

 private:
  static constexpr std::size_t kFirstPurge = 256;  // below it, dead entries cost nothing
  struct Entry {
    std::weak_ptr<const TriangleMesh> mesh;
    std::string hash;
  };
  std::mutex mutex_;
  std::unordered_map<const TriangleMesh*, Entry> entries_;
  std::size_t purge_at_ = kFirstPurge;
};

absl::Status TooLarge(std::string_view what, std::size_t size, std::int64_t limit) {
  return MakeError(
      absl::StatusCode::kResourceExhausted,
      absl::StrCat("geometry: ", absl::string_view(what.data(), what.size()), " is ", size,
                   ", must be at most ", limit),
      {.reason = "GEOMETRY_TOO_LARGE", .metadata = {{"limit", std::to_string(limit)}}});
}

absl::StatusOr<EncodedMesh> EncodeSurface(const collision::PreparedModel& model,
                                          std::int64_t max_triangles, WorkBudget* budget) {
  if (!collision::IsBounded(model)) {
    return MakeError(absl::StatusCode::kFailedPrecondition,
                     "object: has a half-space, must have bounded parts alone to have a surface",
                     {.reason = "SURFACE_UNBOUNDED"});
  }
  const auto surface =
      collision::FullSurfaceOf(model, static_cast<std::size_t>(max_triangles), budget);
  if (HasEnded(budget)) return budget->status();
  if (!surface) {
    return MakeError(
        absl::StatusCode::kResourceExhausted,
        absl::StrCat("object: its surface has more than ", max_triangles,
                     " triangles, must have at most as many"),
        {.reason = "GEOMETRY_TOO_LARGE", .metadata = {{"limit", std::to_string(max_triangles)}}});
  }
  EncodedMesh encoded{.bytes = EncodeMesh(surface->mesh_O),
                      .hash = {},
                      .max_deviation_m = surface->max_deviation_m};
  encoded.hash = HashOf(encoded.bytes, budget);
  if (HasEnded(budget)) return budget->status();
  return encoded;
}

// Bytes of one label or of one point.
std::size_t BytesOfOne(BlobFormat format) {
  return format == BlobFormat::kPointsF32 ? 3 * sizeof(float) : sizeof(std::uint32_t);
}

absl::Status InvalidMesh(const absl::Status& status) {
  return InvalidField("mesh", std::string(status.message()));
}

absl::Status UnknownGeometry(const std::string& hash) {
  return MakeError(absl::StatusCode::kNotFound,
                   absl::StrCat("hash: no geometry \"", hash, "\" is known"),
                   {.reason = "GEOMETRY_UNKNOWN", .metadata = {{"hash", hash}}});
}

// Like ReadMeshColumns, but in pieces that observe the budget: hundreds of megabytes take some
// tenths of a second.
absl::StatusOr<TriangleMesh> ReadColumns(std::string_view bytes, WorkBudget* budget) {
  const absl::StatusOr<MeshCounts> counts = ReadMeshCounts(bytes);
  if (!counts.ok()) return InvalidMesh(counts.status());
  TriangleMesh mesh;
  const char* next = bytes.data() + kMeshCountsBytes;
  const auto read = [&](auto& column, std::size_t count) {
    using Row = typename std::remove_reference_t<decltype(column)>::value_type;
    column.reserve(count);
    return ForEachBlock(count, budget, [&](std::size_t first, std::size_t last) {
      column.resize(last);
      const std::size_t size = (last - first) * sizeof(Row);
      std::memcpy(static_cast<void*>(column.data() + first), next, size);
      next += size;
    });
  };
  if (read(mesh.vertices, counts->vertices) && read(mesh.triangles, counts->triangles)) return mesh;
  return budget->status();
}

}  // namespace

absl::StatusOr<TriangleMesh> DecodeMesh(std::string_view bytes, WorkBudget* budget) {
  auto mesh = ReadColumns(bytes, budget);
  if (!mesh.ok()) return mesh.status();
  const std::optional<Violation> violation = FindViolation(*mesh, budget);
  if (HasEnded(budget)) return budget->status();
  if (violation) {
    return InvalidField(absl::StrCat("mesh.", violation->field),
                        absl::StrCat("is ", violation->value, ", ", violation->rule));
  }
  return mesh;
}

std::string HashOf(std::string_view bytes, WorkBudget* budget) {
  constexpr std::size_t kBytesAtOnce = std::size_t{1} << 20, kBytesOfStep = 64;
  Sha256 sha;
  for (std::size_t at = 0; at < bytes.size() && !HasEnded(budget); at += kBytesAtOnce) {
    const std::string_view piece = bytes.substr(at, kBytesAtOnce);
    sha.Add(piece.data(), piece.size());
    MustEnd(budget, piece.size() / kBytesOfStep);
  }
  return sha.Hex();
}

std::string HashOf(const std::shared_ptr<const TriangleMesh>& mesh) {
  static HashCache& cache = *new HashCache;  // never destroyed
  std::string hash = cache.Find(mesh);
  if (hash.empty()) {
    hash = HashOfEncoding(*mesh);
    cache.Keep(mesh, hash);
  }
  return hash;
}

struct GeometryStore::State {
  struct Entry {
    using WeakMesh = std::weak_ptr<const TriangleMesh>;

    std::shared_ptr<const Blob> blob;        // held while recently used, else nullptr
    std::list<std::string>::iterator used;   // into `recent`, valid while blob is set
    std::uint64_t number = 0;                // identifies this period of holding the blob
    int puts = 0;                            // Puts in this period
    bool was_used = false;                   // its mesh was used by an object or a query
    std::vector<WeakMesh> meshes;            // equal meshes that objects use; usually one
    std::shared_ptr<const MeshFacts> facts;  // of the meshes and the blob; nullptr: not computed
    MeshCaps caps;                           // of the meshes, if the server closed them

    void Add(const std::shared_ptr<const TriangleMesh>& mesh) {
      std::erase_if(meshes, [](const WeakMesh& weak) { return weak.expired(); });
      const auto is_it = [&](const WeakMesh& weak) { return weak.lock() == mesh; };
      if (mesh != nullptr && std::none_of(meshes.begin(), meshes.end(), is_it)) {
        meshes.push_back(mesh);
      }
    }
    // nullptr if no object uses a mesh of this hash any more.
    std::shared_ptr<const TriangleMesh> LivingMesh() const {
      for (const WeakMesh& weak : meshes) {
        if (auto mesh = weak.lock(); mesh != nullptr) return mesh;
      }
      return nullptr;
    }
    bool dead() const { return blob == nullptr && LivingMesh() == nullptr; }
  };

  static constexpr std::size_t kFirstPurge = 1024;  // below it, dead entries are a few 100 kB
  static constexpr std::size_t kMaxFactsOfObjects = 64;

  const std::int64_t max_bytes;
  const std::int64_t max_triangles;
  mutable std::mutex mutex;
  std::unordered_map<std::string, Entry> entries;  // by hash
  std::list<std::string> recent;                   // hashes of held blobs, newest first
  std::int64_t held_bytes = 0;
  std::size_t purge_at = kFirstPurge;
  std::uint64_t last_number = 0;  // the last `number` given to a held blob
  // Hashes of entries without a blob that have facts. A hull takes up to 0.6 MB, so their number is
  // limited.
  std::deque<std::string> facts_of_objects;
  EncodedMeshCache encoded;

  // A decoded mesh takes about as much memory as its bytes.
  static std::int64_t Cost(const Blob& blob) {
    return static_cast<std::int64_t>(blob.bytes->size()) * (blob.mesh == nullptr ? 1 : 2);
  }

  // Dropped blobs are moved out, so that they are freed after the lock.
  using Freed = std::vector<std::shared_ptr<const Blob>>;

  Freed Hold(const std::string& hash, std::shared_ptr<const Blob> blob) {
    Entry& entry = entries[hash];
    recent.push_front(hash);
    entry.used = recent.begin();
    entry.Add(blob->mesh);
    held_bytes += Cost(*blob);
    entry.blob = std::move(blob);
    entry.number = ++last_number;
    entry.puts = 0;
    return Shrink();
  }

  // Drops the blob if this was the last of its holders.
  std::shared_ptr<const Blob> Release(const std::string& hash, std::uint64_t number) {
    const auto found = entries.find(hash);
    if (found == entries.end() || found->second.blob == nullptr || found->second.number != number ||
        --found->second.puts > 0) {
      return nullptr;
    }
    recent.erase(found->second.used);
    return ReleaseBytes(found->second);
  }

  // Drops the entry's blob and facts. The caller removes the hash from `recent`.
  std::shared_ptr<const Blob> ReleaseBytes(Entry& entry) {
    held_bytes -= Cost(*entry.blob);
    entry.facts = nullptr;
    return std::exchange(entry.blob, nullptr);
  }

  // Replaces the blob by the same bytes with their decoded mesh.
  Freed Replace(Entry& entry, std::shared_ptr<const Blob> blob) {
    held_bytes += Cost(*blob) - Cost(*entry.blob);
    entry.Add(blob->mesh);
    entry.blob.swap(blob);
    Freed freed = Shrink();
    freed.push_back(std::move(blob));
    return freed;
  }

  Freed Shrink() {
    Freed freed;
    while (held_bytes > max_bytes && recent.size() > 1) {
      const auto oldest = entries.find(recent.back());
      freed.push_back(ReleaseBytes(oldest->second));
      recent.pop_back();
    }
    PurgeDead();
    return freed;
  }

  // Amortised: one check per insertion.
  void PurgeDead() {
    if (entries.size() < purge_at) return;
    std::erase_if(entries, [](const auto& entry) { return entry.second.dead(); });
    purge_at = 2 * entries.size() + kFirstPurge;
  }

  // The facts of the entry's mesh, kept with the entry from now on.
  std::shared_ptr<const MeshFacts> FactsOf(const std::string& hash, Entry& entry) {
    if (entry.facts != nullptr) return entry.facts;
    entry.facts = std::make_shared<const MeshFacts>(entry.caps);
    if (entry.blob != nullptr) return entry.facts;
    facts_of_objects.push_back(hash);
    if (facts_of_objects.size() > kMaxFactsOfObjects) {
      const auto oldest = entries.find(facts_of_objects.front());
      if (oldest != entries.end() && oldest->second.blob == nullptr) oldest->second.facts = nullptr;
      facts_of_objects.pop_front();
    }
    return entry.facts;
  }

  // The entry of the hash, marked as used; nullptr if its bytes are not available.
  Entry* Touch(const std::string& hash) {
    const auto found = entries.find(hash);
    if (found == entries.end() || found->second.dead()) return nullptr;
    if (found->second.blob != nullptr) {
      recent.splice(recent.begin(), recent, found->second.used);
    }
    return &found->second;
  }
};

GeometryStore::GeometryStore(std::int64_t max_bytes, const Limits& limits)
    : state_(new State{.max_bytes = max_bytes,
                       .max_triangles = limits.max_mesh_triangles,
                       .mutex = {},
                       .entries = {},
                       .recent = {},
                       .held_bytes = 0,
                       .purge_at = State::kFirstPurge,
                       .last_number = 0,
                       .facts_of_objects = {},
                       .encoded = EncodedMeshCache(limits.encoded_mesh_bytes)}) {}
GeometryStore::~GeometryStore() = default;

absl::StatusOr<GeometryStore::Stored> GeometryStore::Put(BlobFormat format, std::string bytes,
                                                         WorkBudget* budget) {
  Stored stored;
  const auto number = Put(format, std::move(bytes), stored, budget);
  if (!number.ok()) return number.status();
  return stored;
}

absl::StatusOr<HeldBlob> GeometryStore::PutTemporary(BlobFormat format, std::string bytes) {
  Stored stored;
  const auto number = Put(format, std::move(bytes), stored, nullptr);
  if (!number.ok()) return number.status();
  const auto release = [weak = std::weak_ptr<State>(state_), hash = stored.hash,
                        number = *number](const void*) {
    const std::shared_ptr<State> state = weak.lock();
    if (state == nullptr) return;
    std::shared_ptr<const Blob> freed;  // freed after the lock
    const std::lock_guard lock(state->mutex);
    freed = state->Release(hash, number);
  };
  return HeldBlob{.hash = stored.hash, .hold = std::shared_ptr<const void>(nullptr, release)};
}

absl::StatusOr<std::uint64_t> GeometryStore::Put(BlobFormat format, std::string bytes,
                                                 Stored& stored, WorkBudget* budget) {
  auto blob = std::make_shared<Blob>();
  blob->format = format;
  if (format == BlobFormat::kMeshF64) {
    const absl::StatusOr<MeshCounts> counts = ReadMeshCounts(bytes);
    if (!counts.ok()) return InvalidMesh(counts.status());
    if (counts->triangles > state_->max_triangles) {
      return TooLarge("triangle_count", counts->triangles, state_->max_triangles);
    }
    absl::StatusOr<TriangleMesh> mesh = DecodeMesh(bytes, budget);
    if (!mesh.ok()) return mesh.status();
    blob->mesh = std::make_shared<const TriangleMesh>(*std::move(mesh));
  } else if (bytes.size() % BytesOfOne(format) != 0) {
    return InvalidField(
        format == BlobFormat::kLabelsU32 ? "labels" : "points",
        absl::StrCat("has ", bytes.size(), " bytes, must be a multiple of ", BytesOfOne(format)));
  }
  blob->bytes = std::make_shared<const std::string>(std::move(bytes));
  if (State::Cost(*blob) > state_->max_bytes) {
    return TooLarge("total_bytes", blob->bytes->size(), state_->max_bytes);
  }
  const std::string hash = HashOf(*blob->bytes, budget);
  if (HasEnded(budget)) return budget->status();
  State::Freed freed;
  std::lock_guard lock(state_->mutex);
  State::Entry* const known = state_->Touch(hash);
  stored = {.hash = hash, .already_known = known != nullptr};
  // A mesh that only living objects held is stored from now on, since its writer will ask for it.
  if (known == nullptr || known->blob == nullptr) {
    freed = state_->Hold(hash, std::move(blob));
  } else if (known->blob->mesh == nullptr && blob->mesh != nullptr) {  // was a label image so far
    freed = state_->Replace(*known, std::move(blob));
  }
  State::Entry& entry = state_->entries[hash];
  ++entry.puts;
  return entry.number;
}

absl::StatusOr<GeometryStore::Stored> GeometryStore::Renew(BlobFormat format, std::string_view hash,
                                                           WorkBudget* budget) {
  const std::string key(hash);
  {
    const std::lock_guard lock(state_->mutex);
    State::Entry* const known = state_->Touch(key);
    if (known != nullptr && known->blob != nullptr && known->blob->format == format) {
      ++known->puts;
      return Stored{.hash = key, .already_known = true};
    }
  }
  const absl::StatusOr<std::shared_ptr<const Blob>> blob = Get(hash);
  if (!blob.ok()) return blob.status();
  return Put(format, *(*blob)->bytes, budget);
}

std::string GeometryStore::RegisterMesh(const std::shared_ptr<const TriangleMesh>& mesh) {
  return RegisterMesh(Mesh{.mesh = mesh});
}

std::string GeometryStore::RegisterMesh(const Mesh& solid) {
  const std::string hash = HashOf(solid.mesh);
  std::lock_guard lock(state_->mutex);
  State::Entry& entry = state_->entries[hash];
  entry.Add(solid.mesh);
  if (solid.caps != nullptr) entry.caps = solid.caps;
  state_->PurgeDead();
  return hash;
}

absl::StatusOr<std::shared_ptr<const Blob>> GeometryStore::Get(std::string_view hash) const {
  const std::string key(hash);
  std::shared_ptr<const TriangleMesh> mesh;
  {
    std::lock_guard lock(state_->mutex);
    if (const State::Entry* entry = state_->Touch(key); entry != nullptr) {
      if (entry->blob != nullptr) return entry->blob;
      mesh = entry->LivingMesh();
    }
  }
  if (mesh == nullptr) return UnknownGeometry(key);
  auto encoded = state_->encoded.Find(mesh);
  if (encoded == nullptr) {
    encoded =
        std::make_shared<const EncodedMesh>(EncodedMesh{.bytes = EncodeMesh(*mesh), .hash = key});
    state_->encoded.Keep(mesh, encoded);
  }
  return std::make_shared<const Blob>(
      Blob{.format = BlobFormat::kMeshF64, .bytes = {encoded, &encoded->bytes}, .mesh = mesh});
}

absl::StatusOr<StoredMesh> GeometryStore::FindMesh(std::string_view hash) const {
  const std::string key(hash);
  const std::lock_guard lock(state_->mutex);
  State::Entry* const entry = state_->Touch(key);
  if (entry == nullptr) return UnknownGeometry(key);
  StoredMesh stored{.mesh = entry->blob != nullptr ? entry->blob->mesh : entry->LivingMesh(),
                    .facts = nullptr};
  if (entry->blob == nullptr && stored.mesh == nullptr) return UnknownGeometry(key);
  if (stored.mesh != nullptr) stored.facts = state_->FactsOf(key, *entry);
  entry->was_used = true;
  return stored;
}

absl::StatusOr<std::shared_ptr<const EncodedMesh>> GeometryStore::SurfaceOf(
    const std::shared_ptr<const collision::PreparedModel>& model, WorkBudget* budget) const {
  if (auto kept = state_->encoded.Find(model); kept != nullptr) return kept;
  auto encoded = EncodeSurface(*model, state_->max_triangles, budget);
  if (!encoded.ok()) return encoded.status();
  auto shared = std::make_shared<const EncodedMesh>(*std::move(encoded));
  state_->encoded.Keep(model, shared);
  return shared;
}

void GeometryStore::DropUnused() {
  State::Freed freed;  // freed after the lock
  {
    const std::lock_guard lock(state_->mutex);
    for (auto hash = state_->recent.begin(); hash != state_->recent.end();) {
      State::Entry& entry = state_->entries.at(*hash);
      const std::shared_ptr<const TriangleMesh>& mesh = entry.blob->mesh;
      const bool is_unused =
          entry.was_used && mesh != nullptr && mesh.use_count() == 1 && entry.blob.use_count() == 1;
      hash = is_unused ? state_->recent.erase(hash) : std::next(hash);
      if (is_unused) freed.push_back(state_->ReleaseBytes(entry));
    }
  }
  state_->encoded.DropExpired();
}

std::int64_t GeometryStore::encoded_count() const { return state_->encoded.made(); }

}  // namespace cwm::server
