#include <yaml-cpp/yaml.h>

#include <array>
#include <cmath>
#include <optional>

#include "absl/strings/str_cat.h"
#include "clients/formats/depth_image.h"
#include "clients/formats/format_error.h"
#include "clients/formats/scalar.h"
#include "clients/formats/text_cursor.h"
#include "clients/formats/yaml_node.h"

namespace cwm::formats {
namespace {

// JSON is YAML.
class CameraReader {
 public:
  CameraReader(std::string_view text, const std::string& file)
      : file_(file), fields_(file, text.size()) {}

  absl::StatusOr<DepthCamera> Read(const YamlNode& root) {
    DepthCamera camera;
    absl::Status status =
        MatrixOf(root).present() ? ReadMatrix(root, camera) : ReadNames(root, camera);
    for (const char* name : {"depth_unit_m", "depth_scale_m", "depth_scale"}) {
      if (!status.ok() || camera.unit_m || !root[name].present()) continue;
      double unit_m = 0;
      status = ReadNumber(root[name], unit_m);
      if (status.ok() && !(unit_m > 0)) status = fields_.Error(root[name], "must be positive");
      camera.unit_m = unit_m;
    }
    if (status.ok()) status = ReadFacts(root, camera);
    if (!status.ok()) return status;
    if (camera.fx_px > 0 && camera.fy_px > 0) return camera;
    return FileError(file_, {"fx and fy", absl::StrCat(camera.fx_px, " and ", camera.fy_px),
                             "must be positive"});
  }

 private:
  static YamlNode MatrixOf(const YamlNode& root) {
    for (const char* name : {"K", "k", "camera_matrix", "intrinsic_matrix"}) {
      const YamlNode node = root[name];
      if (node.present()) return node.is_map() ? node["data"] : node;
    }
    return root["K"];
  }

  absl::Status ReadMatrix(const YamlNode& root, DepthCamera& camera) {
    const auto k = fields_.Numbers(MatrixOf(root), 9);
    if (!k.ok()) return k.status();
    const bool by_columns = root["intrinsic_matrix"].present();
    camera = {.fx_px = (*k)[0],
              .fy_px = (*k)[4],
              .cx_px = (*k)[by_columns ? 6 : 2],
              .cy_px = (*k)[by_columns ? 7 : 5]};
    return absl::OkStatus();
  }

  absl::Status ReadNames(const YamlNode& root, DepthCamera& camera) {
    const std::array<std::pair<std::array<const char*, 2>, double*>, 4> numbers = {{
        {{"fx", "fx"}, &camera.fx_px},
        {{"fy", "fy"}, &camera.fy_px},
        {{"cx", "ppx"}, &camera.cx_px},
        {{"cy", "ppy"}, &camera.cy_px},
    }};
    for (const auto& [names, number] : numbers) {
      const YamlNode node = root[names[0]].present() ? root[names[0]] : root[names[1]];
      if (!node.present()) return FileError(file_, {names[0], "", "is missing from the camera"});
      if (absl::Status status = ReadNumber(node, *number); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::Status ReadFacts(const YamlNode& root, DepthCamera& camera) {
    const std::array<std::pair<const char*, std::optional<double>*>, 2> ranges = {
        {{"min_range_m", &camera.min_range_m}, {"max_range_m", &camera.max_range_m}}};
    for (const auto& [name, range] : ranges) {
      if (!root[name].present()) continue;
      absl::Status status = ReadNumber(root[name], range->emplace());
      if (status.ok() && !(**range > 0)) status = fields_.Error(root[name], "must be positive");
      if (!status.ok()) return status;
    }
    // A given standard deviation is a model of its own.
    const YamlNode sigma = root["sigma_m"];
    const YamlNode model = sigma.present() ? sigma : root["sensor_model"];
    if (!model.present()) return absl::OkStatus();
    auto text = fields_.Scalar(model);
    if (!text.ok()) return text.status();
    camera.sensor_model = *std::move(text);
    return absl::OkStatus();
  }

  absl::Status ReadNumber(const YamlNode& node, double& out) {
    const auto number = fields_.Number(node);
    if (!number.ok()) return number.status();
    if (!std::isfinite(*number)) return fields_.Error(node, "must be finite");
    out = *number;
    return absl::OkStatus();
  }

  const std::string& file_;
  FieldReader fields_;
};

}  // namespace

namespace {

// The nine numbers of a file that holds nothing else.
std::optional<std::array<double, 9>> BareMatrix(std::string_view text) {
  std::array<double, 9> k = {};
  TextCursor cursor(text);
  for (double& number : k) {
    const auto word = cursor.NextWord();
    if (!word || !ParseScalar(*word, Scalar::kF64, reinterpret_cast<char*>(&number))) {
      return std::nullopt;
    }
  }
  if (cursor.NextWord()) return std::nullopt;
  return k;
}

absl::StatusOr<DepthCamera> CameraOf(const std::array<double, 9>& k, const std::string& file) {
  for (const std::size_t i : {0U, 2U, 4U, 5U}) {
    if (!std::isfinite(k[i])) {
      return FileError(file, {"the matrix", FormatNumber(k[i]), "must be of finite numbers"});
    }
  }
  if (k[1] == 0 && k[3] == 0 && k[6] == 0 && k[7] == 0 && k[8] == 1 && k[0] > 0 && k[4] > 0) {
    return DepthCamera{.fx_px = k[0], .fy_px = k[4], .cx_px = k[2], .cy_px = k[5]};
  }
  return FileError(file, {"the matrix", "", "must be fx 0 cx, 0 fy cy, 0 0 1 with fx, fy > 0"});
}

}  // namespace

absl::StatusOr<DepthCamera> ParseDepthCamera(std::string_view text, const std::string& file) {
  // A camera's file has some hundred bytes; a larger one is another file.
  constexpr std::size_t kMaxBytes = 65'536;
  if (text.size() > kMaxBytes) {
    return FileError(file, {"the file", absl::StrCat(text.size(), " bytes"),
                            "must have at most 65536, as a camera's"});
  }
  if (const auto k = BareMatrix(text)) return CameraOf(*k, file);
  try {
    const YamlNode root{YAML::Load(std::string(text)), ""};
    if (!root.is_map()) {
      return FileError(file, {"the file", "", "must be a JSON or YAML object with fx, fy, cx, cy"});
    }
    return CameraReader(text, file).Read(root);
  } catch (const YAML::Exception& error) {
    return FileError(file, {"the file", "", absl::StrCat("is no JSON or YAML: ", error.what())});
  }
}

}  // namespace cwm::formats
