#include "clients/formats/scene_shapes.h"

#include <cmath>
#include <string_view>

#include "absl/strings/str_cat.h"
#include "clients/formats/scalar.h"

namespace cwm::formats {
namespace {

constexpr double kQuaternionTolerance = 0.01;

constexpr PrimitiveKind kBox{"box", 1, 3};
constexpr PrimitiveKind kSphere{"sphere", 2, 1};
constexpr PrimitiveKind kCylinder{"cylinder", 3, 2};
constexpr PrimitiveKind kCone{"cone", 4, 2};

bool HasTwice(const std::array<std::uint32_t, 3>& triangle) {
  return triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
}

}  // namespace

const PrimitiveKind* FindPrimitive(std::string_view word) {
  for (const PrimitiveKind* kind : {&kBox, &kSphere, &kCylinder, &kCone}) {
    if (word == kind->name || word == std::to_string(kind->number)) return kind;
  }
  return nullptr;
}

decltype(SceneShape::shape) MakePrimitive(const PrimitiveKind& kind,
                                          const std::vector<double>& dimensions_m) {
  const std::vector<double>& d = dimensions_m;
  if (&kind == &kBox) return SceneBox{{d[0], d[1], d[2]}};
  if (&kind == &kSphere) return SceneSphere{d[0]};
  if (&kind == &kCylinder) return SceneCylinder{d[0], d[1]};
  return SceneCone{d[0], d[1]};
}

std::optional<std::string> ParseSceneNumber(std::string_view word, double& value) {
  char bytes[sizeof(double)];
  const bool is_number = ParseScalar(word, Scalar::kF64, bytes);
  if (is_number) value = ToDouble(bytes, Scalar::kF64);
  if (!is_number || !std::isfinite(value)) return "must be a finite number";
  if (std::abs(value) <= kMaxSceneNumber) return std::nullopt;
  return absl::StrCat("must be at most ", kMaxSceneNumber, " in magnitude");
}

std::optional<std::string> NormalizeQuaternion(std::array<double, 4>& orientation_xyzw) {
  double squared = 0;
  for (const double q : orientation_xyzw) squared += q * q;
  const double length = std::sqrt(squared);
  if (!(std::abs(length - 1) <= kQuaternionTolerance)) {
    return absl::StrCat("has length ", FormatNumber(length), ", must be within 1 % of 1");
  }
  for (double& q : orientation_xyzw) q /= length;
  return std::nullopt;
}

std::size_t RemoveDegenerateTriangles(MeshFile& mesh) {
  const std::size_t before = mesh.triangles.size();
  std::erase_if(mesh.triangles, HasTwice);
  return before - mesh.triangles.size();
}

}  // namespace cwm::formats
