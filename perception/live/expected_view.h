// The depth image that a camera should see of the known bodies.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "perception/live/depth_image.h"
#include "perception/live/known_body.h"
#include "perception/live/pixel_rectangle.h"

namespace cwm::perception {

class ExpectedView {
 public:
  explicit ExpectedView(const DepthCamera& camera);
  ~ExpectedView();

  // Renders the bodies as seen from X_WC. While the camera's pose is equal to the bit, only the
  // parts of the image in which bodies changed are rendered again. Movers are not rendered.
  // Deterministic: the image depends on the arguments of this call alone, and not on the order of
  // the bodies. Where several are equally near, the one of the least id is seen. Surfaces nearer
  // than 10 mm and those that face away are not rendered, so that a camera inside of a solid sees
  // what is around it.
  void Update(std::span<const KnownBody> bodies, const Pose& X_WC);

  // Depth along the optical axis in metres; infinity where no body is. Row-major.
  const std::vector<float>& depth_m() const { return depth_m_; }
  const std::vector<BodyId>& body() const { return body_; }  // kNoBody where no body is

  // Holds all pixels in which the body is seen; empty if it is not in view.
  PixelRectangle BoundsOf(BodyId id) const;

  // The pixels that the last Update rendered again.
  using Rectangle = PixelRectangle;
  const std::vector<Rectangle>& changed() const { return changed_; }

 private:
  struct State;

  DepthCamera camera_;
  std::vector<float> depth_m_;
  std::vector<BodyId> body_;
  std::vector<Rectangle> changed_;
  std::unique_ptr<State> state_;
};

}  // namespace cwm::perception
