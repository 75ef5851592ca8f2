// The visible faces of a body in an image, ready to be drawn.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "collision/geometry/hybrid_model.h"
#include "perception/live/depth_image.h"
#include "perception/live/known_body.h"
#include "perception/live/pixel_rectangle.h"

namespace cwm::perception {

// Row-major images of the nearest surface so far: the inverse of its depth along the optical axis
// in 1/m, 0 where nothing was drawn, and its body.
struct InverseDepthBuffer {
  int width = 0;
  float* inverse_depth = nullptr;
  BodyId* body = nullptr;
};

// Inverse depths are used since they are linear in the image for every plane, and follow without a
// division for quadrics. Only surfaces that face the camera are drawn, from 10 mm in front of it,
// except for open meshes, which have no inside. Curved surfaces and polygons are exact per pixel;
// the value of a pixel does not depend on the rectangle that is drawn.
class ProjectedBody {
 public:
  ProjectedBody() = default;
  // X_CB: the body in the optical frame.
  ProjectedBody(const HybridModel& model, const Pose& X_CB, const DepthCamera& camera);

  // Holds all pixels that Draw may change.
  const PixelRectangle& bounds() const { return bounds_; }

  // Draws the faces over all that is farther, within a rectangle of the image.
  void Draw(BodyId id, const PixelRectangle& within, const InverseDepthBuffer& buffer) const;

 private:
  class Builder;

  // A side of a projected polygon; v_low < v_high. It crosses the rows [ceil(v_low), ceil(v_high)).
  struct Edge {
    double u_low = 0;
    double v_low = 0;
    double v_high = 0;
    double u_per_v = 0;
  };

  // A planar polygon, filled by the even-odd rule: w = w_0 + w_u u + w_v v.
  struct Polygon {
    double w_0 = 0, w_u = 0, w_v = 0;
    float w_min = 0, w_max = 0;
    std::uint32_t edge_begin = 0, edge_end = 0;
    PixelRectangle bounds = {};
  };

  // Rays in the frame of a shape: origin, and direction with depth 1 of pixel (u, v).
  struct Rays {
    Vector3 origin = Vector3::Zero();
    Vector3 at_0 = Vector3::Zero();
    Vector3 per_u = Vector3::Zero();
    Vector3 per_v = Vector3::Zero();
  };

  // A quadric that rays enter: a w^-2 + 2 b w^-1 + c = 0 along the ray, where
  // a = dx^2 + dy^2 + z_square dz^2 and b = ox dx + oy dy + z_linear dz.
  struct Quadric {
    Rays rays = {};
    double z_square = 0;
    double z_linear = 0;
    double c = 0;
    double slope = 0;             // of the radius along z
    double radius_at_origin = 1;  // radius at the z of the rays' origin; only its sign matters
    double half_length_m = std::numeric_limits<double>::infinity();
    PixelRectangle bounds = {};
  };

  struct Disc {
    Rays rays = {};
    double z = 0;
    double radius_m = 0;
    PixelRectangle bounds = {};
  };

  void Draw(const Polygon& polygon, BodyId id, const PixelRectangle& within,
            const InverseDepthBuffer& buffer, std::vector<double>& crossings) const;

  PixelRectangle bounds_ = {};
  std::vector<Edge> edges_;
  std::vector<Polygon> polygons_;
  std::vector<Quadric> quadrics_;
  std::vector<Disc> discs_;
};

}  // namespace cwm::perception
