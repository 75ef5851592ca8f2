// The scans that benchmarks run on: real ones if they are available, else the virtual scanner's.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/formats/cloud_file.h"
#include "perception/cloud/point_cloud.h"

namespace cwm::benchmarks {

struct BenchmarkScans {
  std::vector<perception::PointCloud> clouds;  // 640 x 480
  std::vector<formats::CloudFile> files;       // the same, x y z alone, as a client uploads them
  std::string source;                          // in words, for the table
};

// Every fifth of the labelled Kinect scans (mosd/learn in CWM_DATA), or nine random tables.
BenchmarkScans LoadBenchmarkScans();

// One of the 45 labelled Kinect scans.
struct LabelledScan {
  perception::PointCloud cloud;
  formats::CloudFile file;            // x y z alone
  std::vector<std::uint32_t> labels;  // made by people, one per point; 0 for no measurement
};

// All of them in order; empty if mosd/learn is not in CWM_DATA.
std::vector<LabelledScan> LoadLabelledScans();

struct NamedCloud {
  std::string name;
  perception::PointCloud cloud;
};

// The depth images of heaps that a RealSense took; empty if real/realsense_clutter is not in
// CWM_DATA.
std::vector<NamedCloud> LoadRealSenseImages();

}  // namespace cwm::benchmarks
