// A shape in the forms of all engines, each built once: the kernels' form with the model, FCL's and
// Bullet's when first used, which is never for most shapes. For a mesh, FCL's form takes 4 times
// the memory of the kernels' form.
#pragma once

#include <memory>

#include "collision/engines/engine.h"

namespace cwm::collision {

class LazyGeometries;

// Copies share the forms. Thread safe.
class PreparedShape {
 public:
  PreparedShape() = default;  // without a shape; operator[] must not be called

  // The form for GetEngine(EngineKind(engine)): immutable, never null, alive as long as a copy of
  // this object. The first call builds it; concurrent calls wait for that.
  const EngineGeometry* operator[](int engine) const;

  // Builds the hulls of a mesh at once, which otherwise the first query builds. For shapes that
  // will surely be queried, so that no query waits. If `work` stops it, the hulls are left to the
  // first query.
  void BuildHulls(WorkCounter* work = nullptr) const;

 private:
  friend PreparedShape PrepareShape(const Shape& shape, WorkCounter* work);

  std::shared_ptr<const LazyGeometries> forms_;
};

// A shape with the kernels' form built, which takes seconds for a mesh of millions of triangles.
// Shapes that refer to the same mesh or hull in memory share their forms as long as one of them is
// alive. The result is without a shape if `work` stopped the construction.
PreparedShape PrepareShape(const Shape& shape, WorkCounter* work = nullptr);

}  // namespace cwm::collision
