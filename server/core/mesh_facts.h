// Facts of a stored mesh that a request may need and that take long to compute: computed once per
// mesh, however often it is mentioned.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "collision/geometry/lazy.h"
#include "collision/geometry/shape.h"

namespace cwm::server {

// measured: the most vertices of a mesh that a Convex may name. Its hull is computed within the
// request; quickhull takes about 20 ms on two cores for so many.
inline constexpr std::size_t kMaxHullInputVertices = 65'536;

// The hull of a mesh's vertices, valid as the shape Convex.
struct MeshHull {
  std::shared_ptr<const TriangleMesh> hull;  // nullptr: the mesh is its own hull
  std::string fault;                         // the error message; empty if there is none
};

// Thread safe. All calls must be about the same mesh. Results are empty (nullptr) if `work` ended
// the computation.
class MeshFacts {
 public:
  // `caps` of a mesh that the server closed itself; nullptr for others.
  explicit MeshFacts(MeshCaps caps = nullptr) : caps_(std::move(caps)) {}

  // The mesh as a shape, closed if it can be (geometry/mesh_closing.h).
  std::optional<Mesh> SolidOf(const std::shared_ptr<const TriangleMesh>& mesh,
                              WorkCounter* work) const;
  // The mesh must have at most kMaxHullInputVertices vertices. The result lives as long as this.
  const MeshHull* HullOf(const std::shared_ptr<const TriangleMesh>& mesh, WorkCounter* work) const;

  // Number of computations, finished or not.
  int computed() const { return computed_; }

 private:
  const MeshCaps caps_;
  Lazy<Mesh> solid_;  // without the mesh if it is the one that was given, to keep none alive
  Lazy<MeshHull> hull_;
  mutable std::atomic<int> computed_ = 0;
};

// A mesh of the store with its facts.
struct StoredMesh {
  std::shared_ptr<const TriangleMesh> mesh;  // nullptr: the blob has another format
  std::shared_ptr<const MeshFacts> facts;    // never null if there is a mesh
};

}  // namespace cwm::server
