// The size of a surface in numbers that do not depend on its frame, to tell twins.
#pragma once

#include "collision/geometry/hybrid_model.h"

namespace cwm::perception {

// The extents of a model's surface along its principal axes, in metres, the largest first: of the
// box whose surface is spread as widely, by second moments. A value.
class ShapeSignature {
 public:
  explicit ShapeSignature(const HybridModel& model);

  // True if the extents differ by no more than a surface may be from the points that it explains
  // (kExplainedWithin_m): measured shapes of one thing differ by that.
  bool IsAlike(const ShapeSignature& other) const;

  const Vector3& extents_m() const { return extents_m_; }

 private:
  Vector3 extents_m_ = Vector3::Zero();
};

}  // namespace cwm::perception
