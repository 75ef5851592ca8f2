// A shape in the forms of all engines, each built once: the kernels' with the model, those of FCL and
// Bullet when they are first asked for, which most shapes never are. A mesh takes 4 times the memory
// of the kernels' form in FCL's.
#pragma once

#include <memory>

#include "collision/engines/engine.h"

namespace cwm::collision {

class LazyForms;

// Copies share the forms. Thread safe.
class PreparedShape {
 public:
  PreparedShape() = default;  // of no shape: not to be asked

  // The form of GetEngine(EngineKind(engine)), immutable and never null, alive as long as a copy of
  // this. The first call builds it, or waits for the one that does.
  const EngineGeometry* operator[](int engine) const;

  // Builds at once what the kernels leave to the first who asks: the hulls of a mesh. For shapes
  // that will surely be asked about, so that no query waits for them. Left to the first who asks
  // where `work` ended it.
  void BuildHulls(WorkCounter* work = nullptr) const;

 private:
  friend PreparedShape PrepareForAll(const Shape& shape, WorkCounter* work);

  std::shared_ptr<const LazyForms> forms_;
};

// With the kernels' form built. Shapes that refer to the same mesh or hull in memory share their
// forms as long as one of them is alive.
// Seconds for a mesh of millions of triangles; of no shape where `work` ended it.
PreparedShape PrepareForAll(const Shape& shape, WorkCounter* work = nullptr);

}  // namespace cwm::collision
