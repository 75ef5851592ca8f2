// The virtual scanner: placed shapes in, a cloud with per-point ground truth out, under a sensor's
// noise. Serves the demo, the tests and the benchmarks.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "collision/geometry/shape.h"
#include "perception/cloud/point_cloud.h"
#include "perception/cloud/sensor_noise.h"

namespace cwm::perception {

struct SimulatedObject {
  std::string name;
  std::vector<Placed<>> parts;  // in the object's frame; the last letter of X_FS is the part
  Pose X_WO = Pose::Identity();
  bool is_support = false;
};

struct SimulatedScene {
  std::vector<SimulatedObject> objects;
};

struct PinholeCamera {
  int width = 640;
  int height = 480;
  double focal_px = 525;
  double center_x_px = 319.5;
  double center_y_px = 239.5;
  Pose X_WC = Pose::Identity();  // optical frame: z forward, x right, y down
};

struct SimulatedCloud {
  PointCloud cloud;  // organised, in C
  std::vector<std::int32_t>
      object;  // per point: index into scene.objects, -1 no return or background
  std::vector<std::int32_t> part;  // per point: part of the object
};

struct ScanOptions {
  SensorNoise noise = {};
  bool noiseless = false;
  std::uint64_t seed = 1;
};

// `noiseless` returns where the rays of the pixels meet the surfaces, to the precision of a float.
// Otherwise: axial and lateral draws as spatially correlated fields (exponential, 4 pixels along
// rows, 2 along columns; the lateral one displaces the ray, so that edges are ragged and slanted
// surfaces noisier), for Kinect and RealSense a slow warp of 1.3 mm rms besides, for Kinect the
// shadow of its projector; mixed pixels at depth edges (object -1: they lie on none), random
// drop-outs (1.5 %) and drop-outs from 70 degrees of incidence to none left at 85. Surfaces deeper
// than 10 m return nothing. The camera is at least one pixel large and its focal length positive.
// Same seed, same bytes.
SimulatedCloud Scan(const SimulatedScene& scene, const PinholeCamera& camera,
                    const ScanOptions& options);

// The scene of the demo: a kitchen counter on its cabinet, before a wall, with boxes, cans, a ball,
// a cup and a mug with a handle; and a camera that sees it from 0.9 m at 45 degrees. World: floor
// at z = 0, top of the counter at z = 0.9.
SimulatedScene KitchenCounter();
PinholeCamera KitchenCamera();

// A random table (object 0) with `object_count` boxes, cylinders, spheres and cups, each of one
// part, that do not touch each other, in view of KitchenCamera. Fewer when the table is full (about
// 15).
SimulatedScene RandomTable(std::uint64_t seed, int object_count);

}  // namespace cwm::perception
