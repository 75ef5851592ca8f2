// A simulated sequence in front of one still sensor, followed by view and tracker without a server.
#pragma once

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "perception/live/robot_view.h"
#include "perception/live/sensor_view.h"
#include "perception/live/tracker.h"
#include "perception/simulation/sequence_renderer.h"
#include "tests/perception/live/known_scene.h"

namespace cwm::perception {

// The changes of one frame.
struct TrackedFrame {
  int frame = 0;
  std::vector<TrackChange> changes = {};
  std::vector<RegionRequest> requests = {};
  FrameEvidence evidence = {};
  std::vector<KnownBody> bodies = {};  // afterwards
  std::map<BodyId, TrackedFacts> facts = {};
  std::vector<ObjectTruth> truth = {};  // by object of the scene
};

class TrackedSequence {
 public:
  explicit TrackedSequence(SequenceScript script) : renderer_(std::move(script)) {
    const SequenceSensor& sensor = renderer_.script().sensors.front();
    bodies_ = KnownBodies(renderer_.script().scene);
    std::erase_if(bodies_, [&](const KnownBody& body) {
      return !ObjectStateAt(renderer_.script(), body.id, 0).is_present;
    });
    view_.emplace(sensor.name, CameraOf(sensor.camera), sensor.noise);
    for (const SimulatedRobot& robot : renderer_.script().robots) AddRobot(robot);
  }

  // Follows all frames. Requests are answered after `interpreting` frames by what is really there.
  std::vector<TrackedFrame> Run(int interpreting = 5) {
    std::vector<TrackedFrame> frames;
    const SequenceScript& script = renderer_.script();
    const SequenceSensor& sensor = script.sensors.front();
    for (int k = 0; k < FrameCount(script, sensor); ++k) {
      Answer(k);
      const SequenceFrame rendered = renderer_.Render(0, k);
      auto image = std::make_shared<DepthImage>();
      image->width = rendered.depth.width;
      image->height = rendered.depth.height;
      image->depth_m = rendered.depth.depth_m;
      const auto stamp = Stamp(std::chrono::duration_cast<Stamp::duration>(
          std::chrono::duration<double>(rendered.stamp_s)));
      TrackedFrame& frame = frames.emplace_back();
      frame.frame = k;
      const std::vector<RobotLinks> robots = RobotsAt(rendered.time_s);
      std::vector<KnownBody> bodies = bodies_;
      tracker_.PlaceCarried(robots, bodies);
      const RobotMask mask = MaskOf(rendered.camera.X_WC, *image, robots, bodies);
      frame.evidence = view_->Observe({stamp, rendered.camera.X_WC, image}, bodies, mask);
      frame.evidence.robots = robots;
      frame.truth = rendered.objects;
      StepResult result = tracker_.Step(frame.evidence, bodies);
      for (const RegionRequest& request : result.requests) {
        pending_.push_back({k + (request.is_whole_view ? 1 : interpreting), request});
      }
      frame.changes = std::move(result.changes);
      frame.requests = std::move(result.requests);
      for (const TrackChange& change : frame.changes) Apply(change);
      frame.bodies = bodies_;
      for (const KnownBody& body : bodies_) frame.facts[body.id] = tracker_.FactsOf(body.id);
    }
    return frames;
  }

  // Another model than the true one, as interpreters make.
  void SetModel(BodyId id, const HybridModel& model) {
    for (KnownBody& body : bodies_) {
      if (body.id == id) body.model = std::make_shared<const HybridModel>(model);
    }
  }

  const SequenceScript& script() const { return renderer_.script(); }
  const SequenceRenderer& renderer() const { return renderer_; }
  const Tracker& tracker() const { return tracker_; }
  const KnownBody* Find(BodyId id) const {
    for (const KnownBody& body : bodies_) {
      if (body.id == id) return &body;
    }
    return nullptr;
  }
  BodyId IdOf(const std::string& name) const {
    const auto& objects = renderer_.script().scene.objects;
    for (std::size_t i = 0; i < objects.size(); ++i) {
      if (objects[i].name == name) return static_cast<BodyId>(i);
    }
    return kNoBody;
  }

 private:
  struct Pending {
    int due = 0;
    RegionRequest request = {};
  };

  struct Robot {
    std::shared_ptr<const LinkTree> tree;
    std::shared_ptr<const RobotSurface> surface;
    std::unique_ptr<RobotView> view;
  };

  // The links' parents are as a chain's, but that of the last one is that of the one before it: two
  // fingers of a hand.
  void AddRobot(const SimulatedRobot& robot) {
    std::vector<LinkGeometry> geometries;
    LinkTree tree;
    for (std::size_t i = 0; i < robot.links.size(); ++i) {
      const auto index = static_cast<int>(i);
      tree.names.push_back(robot.links[i].name);
      tree.parents.push_back(i + 1 == robot.links.size() ? index - 2 : index - 1);
      for (const Placed<>& part : robot.links[i].parts) {
        geometries.push_back({.link = index, .X_LG = part.X_FS, .shape = &part.shape});
      }
    }
    auto surface =
        std::make_shared<const RobotSurface>(geometries, static_cast<int>(robot.links.size()));
    robots_.push_back({std::make_shared<const LinkTree>(std::move(tree)), surface,
                       std::make_unique<RobotView>(surface)});
  }

  std::vector<RobotLinks> RobotsAt(double time_s) const {
    constexpr double kStep_s = 1e-3;
    const SequenceState before = StateAt(script(), time_s - 0.5 * kStep_s);
    const SequenceState now = StateAt(script(), time_s);
    const SequenceState after = StateAt(script(), time_s + 0.5 * kStep_s);
    std::vector<RobotLinks> robots;
    for (std::size_t r = 0; r < robots_.size(); ++r) {
      RobotLinks& links = robots.emplace_back();
      links.robot = script().robots[r].name;
      links.tree = robots_[r].tree;
      links.surface = robots_[r].surface;
      for (std::size_t i = 0; i < now.X_WL[r].size(); ++i) {
        links.links.push_back(
            {now.X_WL[r][i], VelocityBetween(before.X_WL[r][i], after.X_WL[r][i], kStep_s)});
      }
    }
    return robots;
  }

  RobotMask MaskOf(const Pose& X_WC, const DepthImage& image, const std::vector<RobotLinks>& robots,
                   const std::vector<KnownBody>& bodies) {
    RobotMask mask;
    if (robots.empty()) return mask;
    const DepthCamera camera = CameraOf(script().sensors.front().camera);
    const ExpectedView& expected = view_->Expect(bodies, X_WC);
    for (std::size_t r = 0; r < robots.size(); ++r) {
      const RobotSighting sighting = robots_[r].view->Mask(
          {.camera = &camera,
           .X_WC = X_WC,
           .image = &image,
           .noise = script().sensors.front().noise,
           .expected_m = expected.depth_m(),
           .expected_body = expected.body()},
          {.source = StateSource::kInterpolated, .links = robots[r].links}, {}, {});
      MergeMask(sighting.mask, camera, mask);
    }
    return mask;
  }

  void Answer(int k) {
    for (const Pending& pending : pending_) {
      if (pending.due != k) continue;
      if (!pending.request.is_whole_view) AddMissing(k);
      view_->Accept(tracker_.Finish(script().sensors.front().name, pending.request.number));
    }
  }

  // What an interpreter would find: objects that are there at rest and not known.
  void AddMissing(int k) {
    const double time_s = FrameTime_s(script().sensors.front(), k);
    for (const KnownBody& body : KnownBodies(script().scene)) {
      const ObjectState state = ObjectStateAt(script(), body.id, time_s);
      if (!state.is_present || state.is_moving || Find(body.id) != nullptr) continue;
      bodies_.push_back(body);
      bodies_.back().X_WB = state.X_WO;
    }
    std::ranges::sort(bodies_, {}, &KnownBody::id);
  }

  void Apply(const TrackChange& change) {
    if (change.kind == TrackChange::Kind::kRemove) {
      std::erase_if(bodies_, [&](const KnownBody& body) { return body.id == change.body; });
    }
    if (change.kind != TrackChange::Kind::kMove) return;
    for (KnownBody& body : bodies_) {
      if (body.id == change.body) body.X_WB = change.X_WB;
    }
  }

  SequenceRenderer renderer_;
  std::vector<KnownBody> bodies_;
  std::optional<SensorView> view_;
  Tracker tracker_;
  std::vector<Pending> pending_;
  std::vector<Robot> robots_;
};

}  // namespace cwm::perception
