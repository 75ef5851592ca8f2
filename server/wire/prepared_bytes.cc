#include "server/wire/prepared_bytes.h"

#include <string>
#include <unordered_set>

#include "server/core/approximate_bytes.h"

namespace cwm::server {
namespace {

// Counts parts, and the triangles of each distinct mesh once.
class Tally {
 public:
  explicit Tally(const GeometryStore& store) : store_(store) {}

  void Add(const v1::Object& object) {
    for (const v1::ShapePart& part : object.shapes()) {
      ++parts_;
      if (part.has_mesh()) AddMesh(part.mesh().hash());
      if (part.has_convex()) AddMesh(part.convex().hash());
    }
    for (const v1::SurfacePart& part : object.surfaces()) {
      ++parts_;
      AddMesh(part.hash());
    }
  }
  std::int64_t bytes() const { return ApproximatePreparedBytes(parts_, counts_); }

 private:
  void AddMesh(const std::string& hash) {
    if (!meshes_.insert(hash).second) return;
    const auto blob = store_.Get(hash);
    if (!blob.ok() || (*blob)->mesh == nullptr) return;
    counts_.triangles += static_cast<std::int64_t>((*blob)->mesh->triangles.size());
    counts_.vertices += static_cast<std::int64_t>((*blob)->mesh->vertices.size());
  }

  const GeometryStore& store_;
  std::unordered_set<std::string> meshes_;
  std::int64_t parts_ = 0;
  MeshTotals counts_;
};

}  // namespace

std::int64_t PreparedBytes(const google::protobuf::RepeatedPtrField<v1::Change>& changes,
                           const GeometryStore& store) {
  Tally tally(store);
  for (const v1::Change& change : changes) {
    if (change.has_put()) tally.Add(change.put().object());
  }
  return tally.bytes();
}

}  // namespace cwm::server
