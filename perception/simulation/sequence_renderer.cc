#include "perception/simulation/sequence_renderer.h"

#include <algorithm>
#include <utility>

#include "perception/cloud/split_mix.h"

namespace cwm::perception {
namespace {

std::uint64_t FrameSeed(std::uint64_t seed, std::size_t sensor, int frame) {
  const std::uint64_t of_sensor = MixBits(seed + kGoldenGamma * (sensor + 1));
  return MixBits(of_sensor + kGoldenGamma * (static_cast<std::uint64_t>(frame) + 1));
}

DeviceReturns EmptyReturns(const PinholeCamera& camera) {
  DeviceReturns returns{.width = camera.width, .height = camera.height, .pixels = {}};
  returns.pixels.resize(static_cast<std::size_t>(camera.width) * camera.height);
  return returns;
}

}  // namespace

SequenceRenderer::SequenceRenderer(SequenceScript script) : script_(std::move(script)) {
  const auto add = [&](const SequenceBody& body, const SimulatedObject& shape, bool is_still) {
    bodies_.push_back(body);
    shapes_.objects.push_back(shape);
    is_still_.push_back(is_still);
  };
  for (std::size_t i = 0; i < script_.scene.objects.size(); ++i) {
    const bool moves = std::any_of(script_.events.begin(), script_.events.end(),
                                   [&](const ObjectEvent& event) { return event.object == i; });
    add({.kind = SequenceBody::Kind::kObject, .index = i}, script_.scene.objects[i], !moves);
  }
  for (std::size_t i = 0; i < script_.hands.size(); ++i) {
    add({.kind = SequenceBody::Kind::kHand, .index = i}, script_.hands[i].shape, false);
  }
  for (std::size_t i = 0; i < script_.robots.size(); ++i) {
    for (std::size_t link = 0; link < script_.robots[i].links.size(); ++link) {
      add({.kind = SequenceBody::Kind::kRobot, .index = i, .link = link},
          script_.robots[i].links[link], false);
    }
  }
  for (const SequenceSensor& sensor : script_.sensors) {
    devices_.push_back(DrawDeviceErrors(sensor.noise, sensor.camera, sensor.device_seed));
    still_.emplace_back();
    if (!std::holds_alternative<Pose>(sensor.mount)) continue;
    SimulatedScene still = shapes_;
    for (std::size_t i = 0; i < still.objects.size(); ++i) {
      if (!IsStill(i)) still.objects[i].parts.clear();
    }
    still_.back() = RenderAll(still, CameraAt(script_, sensor, 0), devices_.back());
  }
}

SimulatedScene SequenceRenderer::BodiesAt(const SequenceState& state) const {
  SimulatedScene scene = shapes_;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const SequenceBody& body = bodies_[i];
    SimulatedObject& shape = scene.objects[i];
    bool is_present = true;
    switch (body.kind) {
      case SequenceBody::Kind::kObject:
        shape.X_WO = state.objects[body.index].X_WO;
        is_present = state.objects[body.index].is_present;
        break;
      case SequenceBody::Kind::kHand:
        is_present = state.X_WH[body.index].has_value();
        if (is_present) shape.X_WO = *state.X_WH[body.index];
        break;
      case SequenceBody::Kind::kRobot:
        shape.X_WO = state.X_WL[body.index][body.link];
        break;
    }
    if (!is_present) shape.parts.clear();
  }
  return scene;
}

SequenceRenderer::View SequenceRenderer::RenderAll(const SimulatedScene& scene,
                                                   const PinholeCamera& camera,
                                                   const DeviceErrors& device) const {
  View view{.image = EmptyImage(camera), .alone = {}, .returns = EmptyReturns(camera)};
  ImagePainter painter(camera, view.image);
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    view.alone.push_back(painter.Draw(scene.objects[i], static_cast<std::int32_t>(i)).pixel_count);
  }
  ComputeReturns(scene, view.image, camera, device, 0, camera.height, view.returns);
  return view;
}

SequenceRenderer::View SequenceRenderer::RenderOver(const View& still, const SimulatedScene& scene,
                                                    const PinholeCamera& camera,
                                                    const DeviceErrors& device) const {
  View view = still;
  ImagePainter painter(camera, view.image);
  int row_begin = camera.height;
  int row_end = 0;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (IsStill(i)) continue;
    const Silhouette drawn = painter.Draw(scene.objects[i], static_cast<std::int32_t>(i));
    view.alone[i] = drawn.pixel_count;
    if (drawn.pixel_count == 0) continue;
    row_begin = std::min(row_begin, drawn.row_begin);
    row_end = std::max(row_end, drawn.row_end);
  }
  if (row_begin >= row_end) return view;
  // The errors of a time-of-flight camera depend on all surfaces.
  const bool all_rows = device.noise.model == SensorModel::kTimeOfFlight;
  ComputeReturns(
      scene, view.image, camera, device, all_rows ? 0 : std::max(0, row_begin - kReturnRows),
      all_rows ? camera.height : std::min(camera.height, row_end + kReturnRows), view.returns);
  return view;
}

SequenceFrame SequenceRenderer::Render(std::size_t sensor_index, int frame_index) const {
  const SequenceSensor& sensor = script_.sensors[sensor_index];
  const DeviceErrors& device = devices_[sensor_index];
  const double time_s = FrameTime_s(sensor, frame_index);
  SequenceState state = StateAt(script_, time_s);
  const SimulatedScene scene = BodiesAt(state);
  SequenceFrame frame{.index = frame_index,
                      .time_s = time_s,
                      .stamp_s = script_.start_stamp_s + time_s + sensor.clock_offset_s,
                      .camera = CameraAt(script_, sensor, time_s)};
  const View view = still_[sensor_index]
                        ? RenderOver(*still_[sensor_index], scene, frame.camera, device)
                        : RenderAll(scene, frame.camera, device);
  frame.depth =
      DrawFrame(view.returns, device.noise, FrameSeed(script_.seed, sensor_index, frame_index));

  std::vector<std::int64_t> visible(bodies_.size(), 0);
  for (const Sighting& pixel : view.image.pixels) {
    if (pixel.seen()) ++visible[static_cast<std::size_t>(pixel.object)];
  }
  std::vector<std::int64_t> measured(bodies_.size(), 0);
  for (const std::int32_t object : frame.depth.object) {
    if (object >= 0) ++measured[static_cast<std::size_t>(object)];
    frame.mixed_pixel_count += object == kMixedPixel;
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    switch (bodies_[i].kind) {
      case SequenceBody::Kind::kObject:
        frame.objects.push_back({.state = std::move(state.objects[bodies_[i].index]),
                                 .pixel_count = measured[i],
                                 .visible_share = view.alone[i] == 0
                                                      ? 0
                                                      : static_cast<double>(visible[i]) /
                                                            static_cast<double>(view.alone[i])});
        break;
      case SequenceBody::Kind::kHand:
        frame.hand_pixel_count += measured[i];
        break;
      case SequenceBody::Kind::kRobot:
        frame.robot_pixel_count += measured[i];
        break;
    }
  }
  frame.joint_values = std::move(state.joint_values);
  return frame;
}

}  // namespace cwm::perception
