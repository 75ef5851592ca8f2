// A convex polytope inside of D = A - B that grows vertex by vertex, in memory of fixed size.
#pragma once

#include <array>

#include "collision/kernels/convex_core.h"

namespace cwm::collision {

class ExpandingPolytope {
 public:
  using Vertex = CoreDifference::Vertex;

  // Points at most `tolerance_m` above a face count as lying on it.
  explicit ExpandingPolytope(double tolerance_m) : tolerance_(tolerance_m) {}

  // Starts with four vertices that span a volume, in any order.
  void Start(const std::array<Vertex, 4>& corners);

  // The open face with the smallest offset; -1 if all are closed.
  int NearestFace() const;

  // Signed distance of the face's plane from the origin, positive if the origin is behind it.
  double OffsetOf(int face) const { return faces_[Index(face)].offset; }
  const Vector3& NormalOf(int face) const { return faces_[Index(face)].normal; }

  // Takes a face out of the search, because nothing better lies beyond it.
  void Close(int face) { faces_[Index(face)].state = FaceState::kClosed; }

  // Grows to include a vertex beyond `face`. False, and the polytope is unchanged, if the vertex is
  // not beyond the face or rounding would break the surface.
  bool Expand(int face, const Vertex& vertex);

  // True if there is no memory for another vertex.
  bool IsFull() const { return vertex_count_ == kMaxVertices; }

 private:
  // chosen: a budget of about 75 kB on the stack; round cores can exhaust it (README.md).
  static constexpr int kMaxVertices = 384;
  static constexpr int kMaxFaces = 2 * kMaxVertices;  // Euler: 2 V - 4

  enum class FaceState : unsigned char { kFree, kOpen, kClosed };
  struct Face {
    std::array<int, 3> corners;
    std::array<int, 3> neighbours;  // across corners[i] -> corners[i + 1]
    Vector3 normal;                 // unit; zero for a face without area
    double offset;
    FaceState state;
    int visited = 0;  // number of the last expansion that marked it for removal
  };
  struct HorizonEdge {
    int from, to, beyond;
  };

  static std::size_t Index(int i) { return static_cast<std::size_t>(i); }
  const Vector3& W(int vertex) const { return vertices_[Index(vertex)].w; }
  bool IsVisible(const Face& face, const Vector3& eye) const;
  void SetFace(int face, const std::array<int, 3>& corners);
  bool FindHorizon(int seed, const Vector3& eye);
  bool OrderHorizon();
  int TakeFreeFace();

  const double tolerance_;
  int vertex_count_ = 0;
  int face_count_ = 0;
  int expansion_ = 0;
  int removed_count_ = 0;
  int horizon_count_ = 0;
  std::array<Vertex, kMaxVertices> vertices_;
  std::array<Face, kMaxFaces> faces_;
  std::array<int, kMaxFaces> removed_;
  std::array<HorizonEdge, kMaxVertices> horizon_;
};

}  // namespace cwm::collision
