// A budget that ends at a look of its own, for tests of what is read and done under one.
#pragma once

#include "collision/geometry/triangle_mesh.h"
#include "server/core/work_budget.h"

namespace cwm::server {

// As a caller who goes away before the n-th look, counted from 1.
class EndsAtLook : public WorkBudget {
 public:
  explicit EndsAtLook(std::int64_t look) : look_(look) {}

 protected:
  End Look() const override { return looks() >= look_ ? End::kCancelled : End::kNone; }

 private:
  const std::int64_t look_;
};

inline TriangleMesh Tetrahedron() {
  return {.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

}  // namespace cwm::server
