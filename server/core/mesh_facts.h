// Facts of a stored mesh that a request may ask for and that take long to compute: computed once
// per mesh, however often it is mentioned.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "collision/geometry/built_once.h"
#include "collision/geometry/triangle_mesh.h"

namespace cwm::server {

// A Convex is the hull of a named mesh: more vertices than this take too long within a request
// (quickhull: about 20 ms on two cores for as many).
inline constexpr std::size_t kMaxHullInputVertices = 65'536;

// The hull of a mesh's vertices as the shape Convex takes it.
struct MeshHull {
  std::shared_ptr<const TriangleMesh> hull;  // nullptr: the mesh is one already
  std::string fault;                         // what is wrong with it; empty: nothing
};

// Thread safe. All calls are about the same mesh. Answers nothing where `work` ended it.
class MeshFacts {
 public:
  std::optional<bool> IsWatertight(const TriangleMesh& mesh, WorkCounter* work) const;
  // Of at most kMaxHullInputVertices. Lives as long as this.
  const MeshHull* HullOf(const std::shared_ptr<const TriangleMesh>& mesh, WorkCounter* work) const;

  // How often something was computed, whole or not.
  int computed() const { return computed_; }

 private:
  BuiltOnce<bool> watertight_;
  BuiltOnce<MeshHull> hull_;
  mutable std::atomic<int> computed_ = 0;
};

// A mesh of the store with what is known of it.
struct StoredMesh {
  std::shared_ptr<const TriangleMesh> mesh;  // nullptr: the blob has another format
  std::shared_ptr<const MeshFacts> facts;    // never null of a mesh
};

}  // namespace cwm::server
