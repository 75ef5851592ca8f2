#include "collision/kernels/expanding_polytope.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace cwm::collision {

void ExpandingPolytope::Start(const std::array<Vertex, 4>& corners) {
  std::copy(corners.begin(), corners.end(), vertices_.begin());
  vertex_count_ = 4;
  face_count_ = 4;
  const Vector3 n = (W(1) - W(0)).cross(W(2) - W(0));
  if (n.dot(W(3) - W(0)) > 0) std::swap(vertices_[1], vertices_[2]);  // 3 is below (0, 1, 2)
  SetFace(0, {0, 1, 2});
  SetFace(1, {1, 0, 3});
  SetFace(2, {2, 1, 3});
  SetFace(3, {0, 2, 3});
  faces_[0].neighbours = {1, 2, 3};
  faces_[1].neighbours = {0, 3, 2};
  faces_[2].neighbours = {0, 1, 3};
  faces_[3].neighbours = {0, 2, 1};
}

void ExpandingPolytope::SetFace(int index, const std::array<int, 3>& corners) {
  Face& face = faces_[Index(index)];
  face.corners = corners;
  face.state = FaceState::kOpen;
  face.visited = 0;
  const Vector3 &a = W(corners[0]), &b = W(corners[1]), &c = W(corners[2]);
  const Vector3 n = (b - a).cross(c - a);
  const double norm = n.norm();
  if (norm > 0) {
    face.normal = n / norm;
    face.offset = face.normal.dot(a);
    return;
  }
  face.normal.setZero();
  face.offset = std::numeric_limits<double>::infinity();
  face.state = FaceState::kClosed;
}

int ExpandingPolytope::NearestFace() const {
  int best = -1;
  for (int i = 0; i < face_count_; ++i) {
    const Face& face = faces_[Index(i)];
    if (face.state != FaceState::kOpen) continue;
    if (best < 0 || face.offset < faces_[Index(best)].offset) best = i;
  }
  return best;
}

// A face without area counts as visible, since it has no side of its own.
bool ExpandingPolytope::IsVisible(const Face& face, const Vector3& eye) const {
  return face.normal.dot(eye - W(face.corners[0])) > tolerance_ || face.normal.isZero(0);
}

// Fills removed_ with the faces that `eye` sees and horizon_ with their boundary. Marks faces only
// in `visited`. False if the boundary has too many or fewer than three edges.
bool ExpandingPolytope::FindHorizon(int seed, const Vector3& eye) {
  ++expansion_;
  removed_count_ = 0;
  horizon_count_ = 0;
  removed_[Index(removed_count_++)] = seed;
  faces_[Index(seed)].visited = expansion_;
  for (int i = 0; i < removed_count_; ++i) {
    for (const int next : faces_[Index(removed_[Index(i)])].neighbours) {
      Face& face = faces_[Index(next)];
      if (face.visited == expansion_ || !IsVisible(face, eye)) continue;
      face.visited = expansion_;
      removed_[Index(removed_count_++)] = next;
    }
  }
  for (int i = 0; i < removed_count_; ++i) {
    const Face& face = faces_[Index(removed_[Index(i)])];
    for (std::size_t k = 0; k < 3; ++k) {
      if (faces_[Index(face.neighbours[k])].visited == expansion_) continue;
      if (horizon_count_ == kMaxVertices) return false;
      horizon_[Index(horizon_count_++)] = {face.corners[k], face.corners[(k + 1) % 3],
                                           face.neighbours[k]};
    }
  }
  return horizon_count_ >= 3;
}

// Sorts the horizon's edges so that each starts where the previous one ends; false if they are not
// one simple loop.
bool ExpandingPolytope::OrderHorizon() {
  for (int i = 0; i + 1 < horizon_count_; ++i) {
    int found = -1;
    for (int k = i + 1; k < horizon_count_; ++k) {
      if (horizon_[Index(k)].from != horizon_[Index(i)].to) continue;
      if (found >= 0) return false;
      found = k;
    }
    if (found < 0) return false;
    std::swap(horizon_[Index(i + 1)], horizon_[Index(found)]);
  }
  return horizon_[Index(horizon_count_ - 1)].to == horizon_[0].from;
}

int ExpandingPolytope::TakeFreeFace() {
  return removed_count_ > 0 ? removed_[Index(--removed_count_)] : face_count_++;
}

bool ExpandingPolytope::Expand(int seed, const Vertex& vertex) {
  if (IsFull() || !IsVisible(faces_[Index(seed)], vertex.w)) return false;
  if (!FindHorizon(seed, vertex.w) || !OrderHorizon()) return false;
  if (face_count_ + horizon_count_ - removed_count_ > kMaxFaces) return false;
  const int apex = vertex_count_++;
  vertices_[Index(apex)] = vertex;
  std::array<int, kMaxVertices> fan;
  for (int i = 0; i < horizon_count_; ++i) {
    const HorizonEdge& edge = horizon_[Index(i)];
    fan[Index(i)] = TakeFreeFace();
    SetFace(fan[Index(i)], {edge.from, edge.to, apex});
  }
  for (int i = 0; i < horizon_count_; ++i) {
    const HorizonEdge& edge = horizon_[Index(i)];
    const int next = fan[Index((i + 1) % horizon_count_)];
    const int previous = fan[Index((i + horizon_count_ - 1) % horizon_count_)];
    faces_[Index(fan[Index(i)])].neighbours = {edge.beyond, next, previous};
    Face& beyond = faces_[Index(edge.beyond)];
    for (std::size_t k = 0; k < 3; ++k) {
      if (beyond.corners[k] == edge.to && beyond.corners[(k + 1) % 3] == edge.from) {
        beyond.neighbours[k] = fan[Index(i)];
      }
    }
  }
  while (removed_count_ > 0) faces_[Index(TakeFreeFace())].state = FaceState::kFree;
  return true;
}

}  // namespace cwm::collision
