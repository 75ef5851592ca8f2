#include "tests/benchmarks/quality/up_settings.h"

#include <Eigen/Geometry>
#include <numbers>
#include <utility>

#include "perception/simulation/angles.h"
#include "perception/simulation/furniture.h"
#include "perception/simulation/household_goods.h"
#include "perception/simulation/hull_distance.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/random_draws.h"
#include "perception/simulation/random_scenes.h"
#include "perception/simulation/unorganised.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::benchmarks {
namespace {

using namespace perception;

constexpr std::uint64_t kStream = 0x7570;  // of random numbers, different from the families'

Eigen::AlignedBox2d Around(const Vector2& middle, double half_x_m, double half_y_m) {
  const Vector2 half(half_x_m, half_y_m);
  return {middle - half, middle + half};
}

// Puts up to `count` goods upright on a level area, at least a centimetre apart.
void Scatter(int count, const Eigen::AlignedBox2d& area_W, double top_m, SimulatedScene& scene,
             RandomDraws& draws) {
  constexpr int kAttempts = 60;
  constexpr double kMinGap_m = 0.01;
  const std::size_t furniture = scene.objects.size();
  for (int i = 0, added = 0; i < kAttempts && added < count; ++i) {
    SimulatedObject goods =
        DrawGoods(static_cast<GoodsKind>(draws.Below(kGoodsKindCount)), RestPose::kStanding, draws);
    goods.X_WO = MakePose(
        {0, 0, top_m},
        Quaternion(Eigen::AngleAxisd(draws.Uniform(0, 2 * std::numbers::pi), Vector3::UnitZ())));
    const Aabb bounds = BoundsInWorld(goods);
    const Vector2 room_m = area_W.sizes() - bounds.sizes().head<2>();
    if (room_m.minCoeff() < 0) continue;
    for (const Eigen::Index axis : {0, 1}) {
      goods.X_WO.translation()[axis] =
          area_W.center()[axis] - bounds.center()[axis] + draws.Uniform(-0.5, 0.5) * room_m[axis];
    }
    bool is_clear = true;
    for (std::size_t k = furniture; k < scene.objects.size(); ++k) {
      is_clear = is_clear && Clearance_m(scene.objects[k], goods) >= kMinGap_m;
    }
    if (!is_clear) continue;
    goods.name += "_" + std::to_string(++added);
    scene.objects.push_back(std::move(goods));
  }
}

void AddBlock(const char* name, const Vector3& min_W, const Vector3& max_W, SimulatedScene& scene) {
  scene.objects.push_back(MakeBlock(name, Aabb(min_W, max_W)));
}

// A scene and the point that the sensor looks at, from a distance, and the azimuths from which its
// front shows.
struct Setup {
  SimulatedScene scene = {};
  Vector3 target_W = Vector3::Zero();
  double min_distance_m = 0.7, max_distance_m = 1.2;
  double max_azimuth_rad = std::numbers::pi;  // of the view, about x
};

Setup MakeRoom(RandomDraws& draws) {
  Setup room{.min_distance_m = 1.2, .max_distance_m = 2.5, .max_azimuth_rad = Radians(40)};
  const double back_m = draws.Uniform(0.4, 1.2), side_m = draws.Uniform(0.7, 1.6);
  const double top_m = draws.Uniform(0.45, 0.75);
  const double half_x_m = draws.Uniform(0.25, 0.39), half_y_m = draws.Uniform(0.35, 0.6);
  room.scene.objects.push_back(MakeTop("floor", {.area_W = Around({0, 0}, 4, 4), .top_m = 0}));
  room.scene.objects.push_back(
      MakeTop("table", {.area_W = Around({0, 0}, half_x_m, half_y_m), .top_m = top_m}));
  AddBlock("back_wall", {back_m, -4, 0}, {back_m + 0.1, 4, 2.6}, room.scene);
  AddBlock("side_wall", {-4, side_m, 0}, {back_m, side_m + 0.1, 2.6}, room.scene);
  for (const double x : {-0.9, 0.9}) {
    for (const double y : {-0.9, 0.9}) {
      const Vector3 foot(x * half_x_m, y * half_y_m, 0);
      AddBlock("leg", foot - Vector3(0.02, 0.02, 0), foot + Vector3(0.02, 0.02, top_m - 0.03),
               room.scene);
    }
  }
  Scatter(3 + draws.Below(5), Around({0, 0}, half_x_m, half_y_m), top_m, room.scene, draws);
  room.target_W = {0, 0, top_m};
  return room;
}

Setup MakeBin(RandomDraws& draws) {
  Setup bin;
  const double half_x_m = draws.Uniform(0.15, 0.28), half_y_m = draws.Uniform(0.12, 0.22);
  const double height_m = draws.Uniform(0.08, 0.22);
  constexpr double kWall_m = 0.004;
  bin.scene.objects.push_back(MakeTop("floor", {.area_W = Around({0, 0}, 2, 2), .top_m = 0}));
  AddBlock("bin_floor", {-half_x_m, -half_y_m, 0}, {half_x_m, half_y_m, kWall_m}, bin.scene);
  for (const double side : {-1.0, 1.0}) {
    const double x = side * half_x_m, y = side * half_y_m;
    AddBlock("bin_wall", {x - kWall_m, -half_y_m, 0}, {x + kWall_m, half_y_m, height_m}, bin.scene);
    AddBlock("bin_wall", {-half_x_m, y - kWall_m, 0}, {half_x_m, y + kWall_m, height_m}, bin.scene);
  }
  Scatter(3 + draws.Below(7), Around({0, 0}, half_x_m - 0.01, half_y_m - 0.01), kWall_m, bin.scene,
          draws);
  bin.target_W = {0, 0, 0.5 * height_m};
  return bin;
}

Setup MakeShelf(RandomDraws& draws) {
  Setup shelf{.min_distance_m = 0.9, .max_distance_m = 1.8, .max_azimuth_rad = Radians(35)};
  const double half_y_m = draws.Uniform(0.35, 0.6), half_x_m = draws.Uniform(0.12, 0.2);
  const double step_m = draws.Uniform(0.28, 0.4);
  shelf.scene.objects.push_back(MakeTop("floor", {.area_W = Around({0, 0}, 4, 4), .top_m = 0}));
  for (int k = 1; k <= 3; ++k) {
    shelf.scene.objects.push_back(MakeTop(
        "board_" + std::to_string(k),
        {.area_W = Around({0, 0}, half_x_m, half_y_m), .top_m = k * step_m, .thickness_m = 0.02}));
  }
  AddBlock("back_wall", {half_x_m, -4, 0}, {half_x_m + 0.1, 4, 2.6}, shelf.scene);
  for (const double side : {-1.0, 1.0}) {
    AddBlock("side", {-half_x_m, side * half_y_m - 0.01, 0},
             {half_x_m, side * half_y_m + 0.01, 3 * step_m}, shelf.scene);
  }
  for (int k = 1; k <= 3; ++k) {
    Scatter(2 + draws.Below(4), Around({0, 0}, half_x_m, half_y_m - 0.02), k * step_m, shelf.scene,
            draws);
  }
  shelf.target_W = {0, 0, 2 * step_m};
  return shelf;
}

Setup MakeTable(std::uint64_t seed) {
  Setup table;
  table.scene = RandomScene(SceneFamily::kTable, seed).scene;
  Aabb goods;
  for (const SimulatedObject& object : table.scene.objects) {
    if (!object.is_support) goods.extend(BoundsInWorld(object));
  }
  table.target_W = goods.center();
  return table;
}

Setup MakeSingle(RandomDraws& draws) {
  Setup single{.min_distance_m = 0.5, .max_distance_m = 1.0};
  const Eigen::AlignedBox2d area = Around({0, 0}, draws.Uniform(0.3, 0.5), draws.Uniform(0.4, 0.7));
  single.scene.objects.push_back(MakeTop("floor", {.area_W = Around({0, 0}, 3, 3), .top_m = 0}));
  single.scene.objects.push_back(MakeTop("table", {.area_W = area, .top_m = 0.7}));
  Scatter(1, Around({0, 0}, 0.2, 0.2), 0.7, single.scene, draws);
  single.target_W = {0, 0, 0.75};
  return single;
}

Setup MakeSetup(Place place, std::uint64_t seed, RandomDraws& draws) {
  switch (place) {
    case Place::kRoom:
      return MakeRoom(draws);
    case Place::kBin:
      return MakeBin(draws);
    case Place::kShelf:
      return MakeShelf(draws);
    case Place::kTable:
      return MakeTable(seed);
    case Place::kSingle:
    case Place::kKitchen:
      break;
  }
  return MakeSingle(draws);
}

struct Attitude {
  double down_deg = 0, roll_deg = 0;
};

Attitude DrawAttitude(Mounting mounting, RandomDraws& draws) {
  switch (mounting) {
    case Mounting::kUpright:
      return {draws.Uniform(10, 40), draws.Uniform(-5, 5)};
    case Mounting::kTilted:
      return {draws.Uniform(40, 60), draws.Uniform(-30, 30)};
    case Mounting::kOverhead:
      return {draws.Uniform(75, 90), draws.Uniform(-180, 180)};
    case Mounting::kOnSide:
      return {draws.Uniform(10, 40), (draws.Uniform() < 0.5 ? -90 : 90) + draws.Uniform(-5, 5)};
    case Mounting::kUpsideDown:
      break;
  }
  return {draws.Uniform(20, 70), 180 + draws.Uniform(-5, 5)};
}

// The rotation from optical axes to these.
Matrix3 FromOptical(SensorAxes axes) {
  Matrix3 R = Matrix3::Identity();
  if (axes == SensorAxes::kViewer) R.diagonal() << 1, -1, -1;
  if (axes == SensorAxes::kBody) R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R;
}

}  // namespace

std::string UpSetting::name() const {
  return std::string(kPlaceNames[static_cast<std::size_t>(place)]) + ", " +
         std::string(kMountingNames[static_cast<std::size_t>(mounting)]) + ", " +
         (is_list ? "list" : "image") + ", " +
         std::string(kAxesNames[static_cast<std::size_t>(axes)]) + ", seed " + std::to_string(seed);
}

SimulatedView ViewOf(const UpSetting& setting) {
  RandomDraws draws(setting.seed * 25 + static_cast<std::uint64_t>(setting.place) * 5 +
                        static_cast<std::uint64_t>(setting.mounting),
                    kStream);
  const Attitude attitude = DrawAttitude(setting.mounting, draws);
  if (setting.place == Place::kKitchen) {
    SimulatedView kitchen = RandomScene(SceneFamily::kKitchen, setting.seed);
    const double roll_deg =
        setting.mounting == Mounting::kOverhead ? 0.25 * attitude.roll_deg : attitude.roll_deg;
    kitchen.camera.X_WC.rotate(Eigen::AngleAxisd(Radians(roll_deg), Vector3::UnitZ()));
    return kitchen;
  }
  Setup setup = MakeSetup(setting.place, setting.seed, draws);
  const ViewingDirection view{
      .distance_m = draws.Uniform(setup.min_distance_m, setup.max_distance_m),
      .down_rad = Radians(attitude.down_deg),
      .azimuth_rad = draws.Uniform(-setup.max_azimuth_rad, setup.max_azimuth_rad)};
  PinholeCamera camera;
  camera.X_WC = LookAt(setup.target_W, view);
  camera.X_WC.rotate(Eigen::AngleAxisd(Radians(attitude.roll_deg), Vector3::UnitZ()));
  return {.scene = std::move(setup.scene), .camera = camera};
}

std::vector<UpSetting> UpSettings(std::uint64_t first_seed, int seeds) {
  std::vector<UpSetting> settings;
  for (std::size_t place = 0; place < kPlaceNames.size(); ++place) {
    for (std::size_t mounting = 0; mounting < kMountingNames.size(); ++mounting) {
      for (std::uint64_t seed = first_seed; seed < first_seed + static_cast<std::uint64_t>(seeds);
           ++seed) {
        const UpSetting image{static_cast<Place>(place), static_cast<Mounting>(mounting), false,
                              seed % 4 == 3 ? SensorAxes::kBody : SensorAxes::kOptical, seed};
        UpSetting list = image;
        list.is_list = true;
        list.axes = static_cast<SensorAxes>(seed % kAxesNames.size());
        settings.push_back(image);
        settings.push_back(list);
      }
    }
  }
  return settings;
}

UpScan ScanSetting(const UpSetting& setting) {
  const SimulatedView view = ViewOf(setting);
  SimulatedCloud scan = Scan(view.scene, view.camera, {.seed = setting.seed});
  if (setting.is_list) scan = Shuffled(scan, setting.seed);
  const Matrix3 R_PC = FromOptical(setting.axes);
  const Eigen::Matrix3f rotation = R_PC.cast<float>();
  for (Eigen::Vector3f& point : scan.cloud.points) point = rotation * point;
  for (Eigen::Vector3f& normal : scan.cloud.normals) normal = rotation * normal;
  return {.cloud = std::move(scan.cloud),
          .up_C = R_PC * view.camera.X_WC.linear().transpose() * Vector3::UnitZ()};
}

}  // namespace cwm::benchmarks
