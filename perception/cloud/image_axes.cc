#include "perception/cloud/image_axes.h"

#include <utility>
#include <vector>

#include "perception/cloud/quantile.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

Vector3f Without(Vector3f direction, const Vector3& axis) {
  direction -= direction.dot(axis.cast<float>()) * axis.cast<float>();
  return direction;
}

}  // namespace

Vector3 NearestAxis(const Vector3f& direction) {
  Eigen::Index axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  Vector3 unit = Vector3::Zero();
  unit[axis] = direction[axis] < 0 ? -1 : 1;
  return unit;
}

ImageAxes AxesOf(const MeasuredPoints& image) {
  const std::size_t stride = SampleStride(image.image.size());
  Vector3f sum = Vector3f::Zero(), towards_top = Vector3f::Zero();
  float count = 0, rows = 0;
  std::vector<std::pair<float, Vector3f>> rays;  // each ray with its row
  for (std::size_t i = 0; i < image.image.size(); i += stride) {
    if (image.image[i] < 0) continue;
    const Vector3f& point = image.oriented.points[static_cast<std::size_t>(image.image[i])];
    const std::size_t rows_above = i / static_cast<std::size_t>(image.width);
    const auto row = static_cast<float>(rows_above);
    rays.emplace_back(row, point.normalized());
    sum += rays.back().second;
    rows += row;
    ++count;
  }
  for (const auto& [row, ray] : rays) towards_top += (rows / count - row) * ray;
  ImageAxes axes;
  axes.is_all_around = sum.norm() < kMinMeanRay * count;
  const Vector3 forward = NearestAxis(sum);
  if (!axes.is_all_around) towards_top = Without(towards_top, forward);
  if (!(towards_top.norm() > 0)) return axes;
  axes.up = NearestAxis(towards_top);
  if (!axes.is_all_around) {
    axes.forward = forward;
  } else {
    axes.forward = axes.up.x() == 0 ? Vector3(Vector3::UnitX()) : Vector3(Vector3::UnitZ());
  }
  return axes;
}

}  // namespace cwm::perception
