#include "tests/benchmarks/benchmark_scans.h"

#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "clients/formats/cloud_reader.h"
#include "clients/formats/depth_image.h"
#include "clients/formats/file_bytes.h"
#include "perception/simulation/virtual_scanner.h"
#include "tests/support/outside_data.h"

namespace cwm::benchmarks {
namespace {

constexpr int kRealScans = 45;
constexpr int kStride = 5;

static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));

perception::PointCloud ToPointCloud(const formats::CloudFile& file) {
  perception::PointCloud cloud;
  cloud.width = static_cast<int>(file.width);
  cloud.height = static_cast<int>(file.height);
  cloud.points.resize(static_cast<std::size_t>(file.size()));
  std::memcpy(cloud.points.data()->data(), file.bytes.data(),
              cloud.points.size() * sizeof(Eigen::Vector3f));
  return cloud;
}

formats::CloudFile ToFile(const perception::PointCloud& cloud) {
  formats::CloudFile file;
  file.fields = {{.name = "x"}, {.name = "y"}, {.name = "z"}};
  file.point_step = formats::AssignOffsets(file.fields);
  file.width = cloud.width;
  file.height = cloud.height;
  file.bytes.resize(cloud.points.size() * sizeof(Eigen::Vector3f));
  std::memcpy(file.bytes.data(), cloud.points.data()->data(), file.bytes.size());
  return file;
}

// Reads one scan; empty if its layout is not that of this set.
std::optional<LabelledScan> ReadLabelled(const std::string& path) {
  const auto file = formats::ReadCloud(path);
  if (!file.ok()) return std::nullopt;
  const formats::CloudField* label = file->Find("label");
  if (label == nullptr || label->size() != sizeof(std::uint32_t)) return std::nullopt;
  LabelledScan scan;
  scan.file = formats::SelectFields(*file, {"x", "y", "z"});
  scan.cloud = ToPointCloud(scan.file);
  scan.labels.assign(scan.cloud.size(), 0);
  for (std::size_t i = 0; i < scan.labels.size(); ++i) {
    if (!std::isfinite(scan.cloud.points[i].z())) continue;
    std::memcpy(&scan.labels[i], file->bytes.data() + i * file->point_step + label->offset,
                sizeof(std::uint32_t));
  }
  return scan;
}

}  // namespace

std::vector<LabelledScan> LoadLabelledScans() {
  const auto directory = testing::OutsideData("mosd/learn");
  if (!directory) return {};
  std::vector<LabelledScan> scans;
  for (int i = 0; i < kRealScans; ++i) {
    auto scan = ReadLabelled(*directory + "/learn" + std::to_string(i) + ".pcd");
    if (scan) scans.push_back(*std::move(scan));
  }
  return scans;
}

std::vector<NamedCloud> LoadRealSenseImages() {
  const auto directory = testing::OutsideData("real/realsense_clutter");
  if (!directory) return {};
  const auto text = formats::ReadFileBytes(*directory + "/camera.json");
  if (!text.ok()) return {};
  const auto camera = formats::ParseDepthCamera(*text, "camera.json");
  if (!camera.ok()) return {};
  std::vector<NamedCloud> images;
  for (int i = 0;; ++i) {
    const std::string name = "0" + std::to_string(i) + "-depth.png";
    const auto bytes = formats::ReadFileBytes(*directory + "/" + name);
    if (!bytes.ok()) return images;
    const auto file = formats::ParseDepthImage(*bytes, name, *camera);
    if (file.ok()) images.push_back({name, ToPointCloud(*file)});
  }
}

BenchmarkScans LoadBenchmarkScans() {
  BenchmarkScans scans;
  if (const auto directory = testing::OutsideData("mosd/learn")) {
    for (int i = 0; i < kRealScans; i += kStride) {
      const auto file = formats::ReadCloud(*directory + "/learn" + std::to_string(i) + ".pcd");
      if (!file.ok()) continue;
      scans.files.push_back(formats::SelectFields(*file, {"x", "y", "z"}));
      scans.clouds.push_back(ToPointCloud(scans.files.back()));
    }
    scans.source = "every fifth of the 45 labelled Kinect scans (mosd/learn)";
  } else {
    for (std::uint64_t seed = 0; seed < kRealScans / kStride; ++seed) {
      scans.clouds.push_back(perception::Scan(perception::RandomTable(seed, 8),
                                              perception::KitchenCamera(), {.seed = seed})
                                 .cloud);
      scans.files.push_back(ToFile(scans.clouds.back()));
    }
    scans.source = "nine random tables of the virtual scanner (no mosd/learn in CWM_DATA)";
  }
  return scans;
}

}  // namespace cwm::benchmarks
