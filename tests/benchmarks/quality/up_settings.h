// Scenes, mountings of the sensor and frames of its points in which up is to be found.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "perception/cloud/point_cloud.h"
#include "perception/simulation/random_scenes.h"
#include "perception/simulation/simulated_scene.h"

namespace cwm::benchmarks {

// kRoom     a table with goods in the corner of a room
// kBin      an open box with goods in it, on the floor
// kShelf    boards with goods before a back wall
// kTable    the goods of a random table (SceneFamily::kTable)
// kSingle   one thing on a table
// kKitchen  a random kitchen (SceneFamily::kKitchen) in its own view, which is rolled alone: by up
//           to 45 degrees as kOverhead
enum class Place { kRoom, kBin, kShelf, kTable, kSingle, kKitchen };
inline constexpr std::array<std::string_view, 6> kPlaceNames = {"room",  "bin",    "shelf",
                                                                "table", "single", "kitchen"};

// kUpright     looks 10 to 40 degrees down, rolled by up to 5
// kTilted      looks 40 to 60 degrees down, rolled by up to 30
// kOverhead    looks 75 to 90 degrees down, rolled by any angle
// kOnSide      as kUpright, rolled by 90 degrees more
// kUpsideDown  looks 20 to 70 degrees down, rolled by 180
enum class Mounting { kUpright, kTilted, kOverhead, kOnSide, kUpsideDown };
inline constexpr std::array<std::string_view, 5> kMountingNames = {"upright", "tilted", "overhead",
                                                                   "on its side", "upside down"};

// The axes of the frame of the points, by the sensor's view: optical (z forward, y down), viewer (z
// backward, y up), body (x forward, z up).
enum class SensorAxes { kOptical, kViewer, kBody };
inline constexpr std::array<std::string_view, 3> kAxesNames = {"optical", "viewer", "body"};

struct UpSetting {
  Place place = Place::kRoom;
  Mounting mounting = Mounting::kUpright;
  bool is_list = false;  // its points are shuffled, and those without a return left out
  SensorAxes axes = SensorAxes::kOptical;
  std::uint64_t seed = 0;

  std::string name() const;
};

// `seeds` of each place and mounting, as images (in optical and body axes) and as lists (in all
// axes).
std::vector<UpSetting> UpSettings(std::uint64_t first_seed, int seeds);

struct UpScan {
  perception::PointCloud cloud;
  Vector3 up_C = Vector3::UnitZ();  // the true up in the frame of the points
};

// The scene of a setting and the camera that looks at it.
perception::SimulatedView ViewOf(const UpSetting& setting);

// The setting as a Kinect sees it. The same setting gives the same bytes.
UpScan ScanSetting(const UpSetting& setting);

}  // namespace cwm::benchmarks
