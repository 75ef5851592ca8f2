// A simulated sequence in front of one still sensor, followed by view and tracker without a server.
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

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
      frame.evidence = view_->Observe({stamp, rendered.camera.X_WC, image}, bodies_, {});
      StepResult result = tracker_.Step(frame.evidence, bodies_);
      for (const RegionRequest& request : result.requests) {
        pending_.push_back({k + (request.is_whole_view ? 1 : interpreting), request});
      }
      frame.changes = std::move(result.changes);
      frame.requests = std::move(result.requests);
      for (const TrackChange& change : frame.changes) Apply(change);
    }
    return frames;
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
};

}  // namespace cwm::perception
