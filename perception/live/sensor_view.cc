#include "perception/live/sensor_view.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "perception/live/body_evidence.h"
#include "perception/live/compare_frame.h"
#include "perception/live/hot_regions.h"
#include "perception/live/outline_template.h"
#include "perception/live/past_views.h"
#include "perception/live/pose_estimate.h"
#include "perception/live/reference_image.h"

namespace cwm::perception {

namespace {
constexpr float kNothing_m = std::numeric_limits<float>::infinity();
// chosen: a correction of a pose that is as small changes no class of a pixel.
constexpr double kMinCorrection_m = 0.001;
constexpr double kMinCorrection_px = 0.5;
}  // namespace

struct SensorView::State {
  // A body's template follows the reference while that is learnt, and later its slow changes.
  struct BodyView {
    MotionTemplate motion = {};
    OutlineTemplate outline = {};
    int frames_since_change = 0;
    int frames_since_move = std::numeric_limits<int>::max();  // of the body itself

    bool MustBuild(BodyId id) const {
      constexpr int kLearnt = ReferenceImage::kUsableFrames;
      constexpr int kRenewedFrames = 256;
      const int frames = frames_since_change;
      return frames == 0 || frames == kLearnt || frames == 3 * kLearnt || frames == 9 * kLearnt ||
             (frames + id) % kRenewedFrames == 0;  // in turn
    }
  };

  struct KnownPose {
    BodyId id = kNoBody;
    Pose X_WB = Pose::Identity();
    std::shared_ptr<const HybridModel> model = nullptr;
  };

  State(std::string sensor, const DepthCamera& its_camera, const SensorNoise& its_noise)
      : name(std::move(sensor)),
        camera(its_camera),
        noise(camera, its_noise),
        view(camera),
        gates(camera.width, camera.height),
        reference(camera, noise),
        regions(camera, noise),
        past(camera, noise),
        expected_m(camera.pixel_count(), std::numeric_limits<float>::infinity()),
        body(camera.pixel_count(), kNoBody),
        pixel_counts(static_cast<std::size_t>(kNoBody) + 1, 0) {}

  PixelRectangle whole() const { return {.u_end = camera.width, .v_end = camera.height}; }

  // The bodies that have only another pose than before, by ascending id.
  std::vector<BodyId> MovedBodies(std::span<const KnownBody> bodies) const;
  // Takes over the expected view: its gates, the reference where bodies changed, the pixels of each
  // body.
  void TakeExpected(std::span<const KnownBody> bodies, const DepthImage& image,
                    const RobotMask& robots);
  void ChangePixel(std::size_t i, float depth_m, std::span<const BodyId> moved);
  // True if the reference of a pixel still holds though another depth or body is expected.
  // `is_asserted`: a body is expected there because it moved there; else it was modelled anew.
  bool StillHolds(std::size_t i, float depth_m, bool is_asserted) const;
  bool IsInReference(std::size_t i, float depth_m) const {
    return depth_m >= reference.low_m()[i] && depth_m <= reference.high_m()[i];
  }
  bool ContradictsReference(std::size_t i) const {
    const float mean_m = reference.mean_m()[i];
    return mean_m < gates.low_m()[i] || mean_m > gates.high_m()[i];
  }
  void MarkChanged(BodyId id);
  // True if the body was given another pose some frames ago: it moves.
  bool HasJustMoved(BodyId id) const {
    constexpr int kJust_frames = 10;
    const auto found = bodies_in_view.find(id);
    return found != bodies_in_view.end() && found->second.frames_since_move <= kJust_frames;
  }
  std::vector<BodyEvidence> Evidence(std::span<const KnownBody> bodies, const DepthImage& image,
                                     const FrameClasses& classes, const PixelRays& rays);
  // Fills `shown` and `passed` of a body for a sensor that moves.
  void CountPassedWhileMoving(const FrameClasses& frame_classes, BodyEvidence& evidence) const;
  std::shared_ptr<FrameClasses> FreshClasses();
  Pose Corrected(const Pose& X_WC_given) const;
  const ExpectedView& Expect(std::span<const KnownBody> bodies, const Pose& X_WC);
  // Corrects the pose of a frame of a sensor that moves.
  void CorrectPose(const SensorFrame& frame, std::span<const KnownBody> bodies,
                   const RobotMask& robots);

  std::string name;
  DepthCamera camera;
  DepthNoise noise;
  ExpectedView view;
  ExpectedGates gates;
  ReferenceImage reference;
  HotRegions regions;
  PastViews past;  // of a sensor that moves
  SeenSurface seen;
  BodyPixels by_body;
  BlockCounts blocks;

  bool has_frame = false;
  bool is_moving = false;              // the last frame had another pose than the one before
  bool has_moved = false;              // any frame had
  Pose X_WC_given = Pose::Identity();  // of the last frame
  Pose X_WC = Pose::Identity();        // the same, corrected
  // The correction of the last frame: it moves the sensor by `shift_W`, and turns it by `turn_W`.
  Vector3 shift_W = Vector3::Zero();
  Matrix3 turn_W = Matrix3::Identity();
  PoseEstimate estimate = {};                   // of the last frame of a sensor that moves
  std::shared_ptr<const DepthImage> image;      // the last one
  std::shared_ptr<FrameClasses> classes;        // of the last frame
  std::shared_ptr<FrameClasses> other_classes;  // of the frame before, to be used again

  // The expected view that the reference and the gates were made for.
  std::vector<float> expected_m;
  std::vector<BodyId> body;
  std::vector<int> pixel_counts;  // by id
  std::vector<KnownPose> poses;   // by ascending id
  std::vector<PixelRectangle> changed;
  // 1 for the pixels in which an interpreted frame showed something else than the reference holds,
  // until the next change of the expected view; empty: there are none.
  std::vector<std::uint8_t> has_left;
  std::map<BodyId, BodyView> bodies_in_view;
  BodyId last_changed = kNoBody;  // by MarkChanged, in this frame
};

std::vector<BodyId> SensorView::State::MovedBodies(std::span<const KnownBody> bodies) const {
  std::vector<BodyId> moved;
  for (const KnownBody& known : bodies) {
    const auto old = std::ranges::lower_bound(poses, known.id, {}, &KnownPose::id);
    if (old == poses.end() || old->id != known.id || old->model != known.model) continue;
    if (old->X_WB.matrix() != known.X_WB.matrix()) moved.push_back(known.id);
  }
  std::ranges::sort(moved);
  return moved;
}

void SensorView::State::MarkChanged(BodyId id) {
  if (id == last_changed || id == kNoBody) return;  // most neighbours are of one body
  last_changed = id;
  bodies_in_view[id].frames_since_change = 0;
}

bool SensorView::State::StillHolds(std::size_t i, float depth_m, bool is_asserted) const {
  const bool looks_the_same = IsInReference(i, depth_m);
  if (depth_m != 0 && !looks_the_same) return false;
  // A new model is as good as what it was made of: a pixel in which it errs shows no change, unless
  // it was made of what has left.
  const bool is_of_now = !is_asserted && (has_left.empty() || has_left[i] == 0);
  if (is_of_now && (looks_the_same || expected_m[i] == kNothing_m)) return looks_the_same;
  return !ContradictsReference(i);
}

void SensorView::State::ChangePixel(std::size_t i, float depth_m, std::span<const BodyId> moved) {
  const float before_m = std::exchange(expected_m[i], view.depth_m()[i]);
  const BodyId before = std::exchange(body[i], view.body()[i]);
  if (before_m == expected_m[i] && before == body[i]) return;
  if (before != body[i]) {
    --pixel_counts[before];
    ++pixel_counts[body[i]];
    MarkChanged(before);
  }
  MarkChanged(body[i]);
  if (is_moving || !reference.Knows(i)) return;
  const bool moves_with_body =
      before == body[i] && std::ranges::binary_search(moved, before) &&
      std::abs(reference.mean_m()[i] - before_m) <= noise.Explained_m(before_m);
  if (moves_with_body) {
    reference.Shift(i, expected_m[i] - before_m);
  } else if (!StillHolds(i, depth_m, std::ranges::binary_search(moved, body[i]))) {
    reference.ForgetPixel(i);
  }
}

void SensorView::State::TakeExpected(std::span<const KnownBody> bodies, const DepthImage& frame,
                                     const RobotMask& robots) {
  last_changed = kNoBody;
  if (changed.empty()) return;
  const std::vector<BodyId> moved = MovedBodies(bodies);
  int radius_px = ExpectedGates::kStillRadius_px;
  if (is_moving) {
    radius_px =
        ExpectedGates::MovingRadius_px(estimate.sigma.rotation_rad * camera.pinhole.focal_u_px);
    noise.SetPoseError(estimate.depth_sigma_m);
  }
  for (const PixelRectangle& rectangle : changed) {
    gates.Refresh(rectangle, view.depth_m(), noise, is_moving, radius_px);
  }
  for (const PixelRectangle& rectangle : changed) {
    for (int v = rectangle.v_begin; v < rectangle.v_end; ++v) {
      for (int u = rectangle.u_begin; u < rectangle.u_end; ++u) {
        const std::size_t i = static_cast<std::size_t>(v) * camera.width + u;
        const bool is_robot = !robots.empty() && robots.pixels[i] != 0;
        ChangePixel(i, is_robot ? 0 : frame.depth_m[i], moved);
      }
    }
  }
  for (const PixelRectangle& rectangle : changed) {
    if (is_moving) break;
    reference.RefreshGates(
        Grown(rectangle, ExpectedGates::kStillRadius_px, camera.width, camera.height), expected_m);
  }
  changed.clear();
  has_left.clear();
  for (const BodyId id : moved) {
    const auto found = bodies_in_view.find(id);
    if (found != bodies_in_view.end()) found->second.frames_since_move = 0;
  }
  poses.clear();
  for (const KnownBody& known : bodies) poses.push_back({known.id, known.X_WB, known.model});
  std::ranges::sort(poses, {}, &KnownPose::id);
  std::erase_if(bodies_in_view,
                [this](const auto& entry) { return pixel_counts[entry.first] == 0; });
}

void SensorView::State::CountPassedWhileMoving(const FrameClasses& frame_classes,
                                               BodyEvidence& evidence) const {
  const PixelRectangle bounds = view.BoundsOf(evidence.id);
  for (int v = bounds.v_begin; v < bounds.v_end; ++v) {
    for (int u = bounds.u_begin; u < bounds.u_end; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * camera.width + u;
      if (body[i] != evidence.id) continue;
      if (frame_classes.pixels[i] == PixelClass::kFarther) ++evidence.passed;
      if (frame_classes.pixels[i] != PixelClass::kConsistent) continue;
      const float tolerance_m = noise.ExplainedWhileMoving_m(expected_m[i]);
      if (gates.high_m()[i] <= expected_m[i] + 2 * tolerance_m) ++evidence.shown;
    }
  }
}

std::vector<BodyEvidence> SensorView::State::Evidence(std::span<const KnownBody> bodies,
                                                      const DepthImage& frame,
                                                      const FrameClasses& frame_classes,
                                                      const PixelRays& rays) {
  const auto count = [this](BodyId id, PixelClass pixel) {
    return static_cast<int>(by_body.of(id)[static_cast<std::size_t>(pixel)]);
  };
  std::vector<BodyEvidence> evidence;
  std::vector<const KnownBody*> known_of;
  for (const KnownBody& known : bodies) {
    if (pixel_counts[known.id] > 0 && known.kind != KnownBody::Kind::kMover) {
      known_of.push_back(&known);
    }
  }
  std::ranges::sort(known_of, {}, &KnownBody::id);
  const bool has_reference = !is_moving && reference.usable();
  for (const KnownBody* const known : known_of) {
    BodyEvidence of_body;
    of_body.id = known->id;
    of_body.expected = pixel_counts[known->id];
    of_body.nearer = count(known->id, PixelClass::kNearer);
    of_body.farther = count(known->id, PixelClass::kFarther);
    of_body.missing = count(known->id, PixelClass::kMissing);
    of_body.hidden = count(known->id, PixelClass::kRobot) + count(known->id, PixelClass::kCarried) +
                     count(known->id, PixelClass::kMixed) + count(known->id, PixelClass::kHidden);
    of_body.consistent =
        of_body.expected - of_body.nearer - of_body.farther - of_body.missing - of_body.hidden;
    if (has_reference && known->IsFollowed()) {
      BodyView& body_view = bodies_in_view[known->id];
      if (body_view.MustBuild(known->id)) {
        const bool has_moved = body_view.frames_since_move == 0;
        body_view.motion.Build(*known, of_body.expected, has_moved, view, camera, rays, X_WC,
                               reference);
        body_view.outline.Build(*known, has_moved, view, camera, rays, X_WC, reference, noise);
      }
      ++body_view.frames_since_change;
      body_view.motion.Measure(frame, frame_classes, of_body);
      body_view.outline.Measure(frame, frame_classes, reference, of_body);
    }
    evidence.push_back(std::move(of_body));
  }
  MarkHotBodies(frame_classes, body, evidence);
  for (auto& [id, body_view] : bodies_in_view) {
    if (body_view.frames_since_move < std::numeric_limits<int>::max())
      ++body_view.frames_since_move;
  }
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    if (!known_of[i]->IsFollowed()) continue;
    if (evidence[i].is_hot && is_moving) {
      CountPassedWhileMoving(frame_classes, evidence[i]);
    } else if (evidence[i].is_hot) {
      CountPassed(view, frame, frame_classes, reference, noise, evidence[i]);
    } else if (!HasJustMoved(evidence[i].id)) {
      continue;
    }
    evidence[i].points_L = PointsOfBody(evidence[i].id, evidence[i].expected, view, frame, camera,
                                        frame_classes, rays);
  }
  return evidence;
}

// Classes that nobody else holds; those of the frame before last if possible.
std::shared_ptr<FrameClasses> SensorView::State::FreshClasses() {
  std::swap(classes, other_classes);
  if (classes == nullptr || classes.use_count() > 1) classes = std::make_shared<FrameClasses>();
  return classes;
}

SensorView::SensorView(std::string sensor, const DepthCamera& camera, const SensorNoise& noise)
    : state_(std::make_unique<State>(std::move(sensor), camera, noise)) {}

SensorView::~SensorView() = default;

Pose SensorView::State::Corrected(const Pose& X_WC_given_now) const {
  // To the bit while the sensor stands.
  if (has_frame && X_WC_given_now.matrix() == X_WC_given.matrix()) return X_WC;
  Pose corrected = X_WC_given_now;
  corrected.translation() += shift_W;
  corrected.linear() = turn_W * X_WC_given_now.linear();
  return corrected;
}

const ExpectedView& SensorView::State::Expect(std::span<const KnownBody> bodies,
                                              const Pose& X_WC_now) {
  view.Update(bodies, X_WC_now);
  changed.insert(changed.end(), view.changed().begin(), view.changed().end());
  return view;
}

void SensorView::State::CorrectPose(const SensorFrame& frame, std::span<const KnownBody> bodies,
                                    const RobotMask& robots) {
  const Pose X_WC_before = X_WC;
  estimate =
      EstimatePose(view, X_WC, *frame.image, robots, camera, noise, frame.X_WC, frame.pose_sigma);
  // What is much less than the tolerances is not worth another view.
  const Eigen::AngleAxisd turn(Matrix3(estimate.X_WC.linear() * X_WC.linear().transpose()));
  if ((estimate.X_WC.translation() - X_WC.translation()).norm() < kMinCorrection_m &&
      turn.angle() * camera.pinhole.focal_u_px < kMinCorrection_px) {
    return;
  }
  X_WC = estimate.X_WC;
  shift_W = X_WC.translation() - frame.X_WC.translation();
  turn_W = X_WC.linear() * frame.X_WC.linear().transpose();
  if (X_WC.matrix() == X_WC_before.matrix()) return;
  changed.clear();
  Expect(bodies, X_WC);
}

const ExpectedView& SensorView::Expect(std::span<const KnownBody> bodies, const Pose& X_WC) {
  return state_->Expect(bodies, state_->Corrected(X_WC));
}

FrameEvidence SensorView::Observe(const SensorFrame& frame, std::span<const KnownBody> bodies,
                                  const RobotMask& robots) {
  State& state = *state_;
  const DepthCamera& camera = state.camera;
  assert(frame.image != nullptr && frame.image->depth_m.size() == camera.pixel_count());
  const DepthImage& image = *frame.image;
  const bool is_same_pose = state.X_WC_given.matrix() == frame.X_WC.matrix();
  const bool is_still = state.has_frame && is_same_pose;
  const bool was_moving = state.is_moving;
  state.is_moving = state.has_frame && !is_same_pose;
  state.X_WC = state.Corrected(frame.X_WC);
  state.has_frame = true;
  state.X_WC_given = frame.X_WC;
  if (state.is_moving && !was_moving) state.reference.Forget();

  state.Expect(bodies, state.X_WC);
  if (state.is_moving) state.CorrectPose(frame, bodies, robots);
  // Tolerances are others while the sensor moves.
  if (was_moving != state.is_moving) state.changed.assign(1, state.whole());
  state.TakeExpected(bodies, image, robots);

  const PixelRays rays(camera, state.X_WC);
  state.by_body.Clear();
  FrameClasses& classes = *state.FreshClasses();
  const KnownView known = {.expected_m = &state.expected_m,
                           .body = &state.body,
                           .gates = &state.gates,
                           .reference = state.is_moving ? nullptr : &state.reference,
                           .is_first = !state.is_moving && !state.reference.usable(),
                           .seen = state.is_moving && !state.seen.empty() ? &state.seen : nullptr,
                           .X_WC = state.X_WC};
  CompareFrame(image, camera, known, robots, classes, state.by_body, state.blocks);

  FrameEvidence evidence;
  evidence.sensor = state.name;
  evidence.stamp = frame.stamp;
  evidence.X_WC = state.X_WC;
  evidence.is_still = is_still;
  evidence.may_move = frame.may_move;
  evidence.is_moving = state.is_moving;
  if (state.is_moving) evidence.pose_sigma = state.estimate.sigma;
  evidence.camera = camera;
  evidence.noise = state.noise.model();
  evidence.image = frame.image;
  evidence.classes = state.classes;
  evidence.has_reference = !state.is_moving && state.reference.usable();
  evidence.bodies = state.Evidence(bodies, image, classes, rays);
  const HotRegions::MovingSensor moving = {
      .X_WC = state.X_WC, .sigma = evidence.pose_sigma, .past = &state.past};
  evidence.regions = state.regions.Find({image, classes, state.body, rays, state.reference},
                                        frame.stamp, is_still, state.is_moving ? &moving : nullptr);

  state.has_moved |= state.is_moving;
  if (state.has_moved) {
    state.past.Keep(frame.image, state.X_WC, evidence.pose_sigma, frame.stamp);
  }
  if (!state.is_moving) {
    state.reference.Learn(
        {.depth_m = image.depth_m, .classes = &classes, .expected_m = state.expected_m});
  }
  state.image = frame.image;
  return evidence;
}

void SensorView::Remember(const FrameEvidence& frame, std::span<const std::int32_t> blocks,
                          std::span<const KnownBody> bodies) {
  const DepthCamera& camera = state_->camera;
  ExpectedView view(camera);
  view.Update(bodies, frame.X_WC);
  ExpectedGates gates(camera.width, camera.height);
  gates.Refresh(state_->whole(), view.depth_m(), state_->noise, /*is_moving=*/true);
  state_->seen.Add(frame, blocks, gates);
}

void SensorView::Accept(std::span<const std::int32_t> blocks) {
  State& state = *state_;
  if (state.image == nullptr || state.is_moving) return;
  const FrameClasses& classes = *state.classes;
  state.last_changed = kNoBody;
  for (const std::int32_t block : blocks) {
    if (block < 0 || static_cast<std::size_t>(block) >= classes.hot_blocks.size()) continue;
    const PixelRectangle pixels = classes.PixelsOf(block);
    for (int v = pixels.v_begin; v < pixels.v_end; ++v) {
      for (int u = pixels.u_begin; u < pixels.u_end; ++u) {
        const std::size_t i = static_cast<std::size_t>(v) * classes.width + u;
        const PixelClass pixel = classes.pixels[i];
        if (pixel == PixelClass::kMissing) {
          state.reference.ForgetPixel(i);
        } else if (pixel == PixelClass::kConsistent || pixel == PixelClass::kNearer ||
                   pixel == PixelClass::kFarther) {
          state.reference.Take(i, state.image->depth_m[i]);
          state.MarkChanged(state.body[i]);
        }
      }
    }
    state.reference.RefreshGates(
        Grown(pixels, ExpectedGates::kStillRadius_px, classes.width, classes.height),
        state.expected_m);
  }
}

void SensorView::NoteInterpreted(const FrameEvidence& frame, std::span<const std::int32_t> blocks) {
  State& state = *state_;
  const FrameClasses& then = *frame.classes;
  if (state.is_moving || then.pixels.size() != state.body.size()) return;
  state.has_left.resize(then.pixels.size());
  state.last_changed = kNoBody;
  for (const std::int32_t block : blocks) {
    const PixelRectangle pixels = then.PixelsOf(block);
    for (int v = pixels.v_begin; v < pixels.v_end; ++v) {
      for (int u = pixels.u_begin; u < pixels.u_end; ++u) {
        const std::size_t i = static_cast<std::size_t>(v) * then.width + u;
        const float then_m = frame.image->depth_m[i];
        if (then_m == 0 || !state.reference.Knows(i) || state.IsInReference(i, then_m)) continue;
        state.has_left[i] = 1;
        // A frame that came meanwhile was compared with the body.
        const bool is_expected = state.expected_m[i] != kNothing_m;
        if (!is_expected || !state.ContradictsReference(i)) continue;
        state.reference.ForgetPixel(i);
        state.MarkChanged(state.body[i]);
      }
    }
    state.reference.RefreshGates(
        Grown(pixels, ExpectedGates::kStillRadius_px, then.width, then.height), state.expected_m);
  }
}

void SensorView::ForgetHidden(const FrameEvidence& frame) {
  State& state = *state_;
  if (frame.classes->pixels.size() != state.body.size()) return;  // of another camera
  state.last_changed = kNoBody;
  for (std::size_t i = 0; i < state.body.size(); ++i) {
    const PixelClass pixel = frame.classes->pixels[i];
    const bool is_hidden = pixel == PixelClass::kRobot || pixel == PixelClass::kCarried ||
                           pixel == PixelClass::kMixed || pixel == PixelClass::kHidden;
    if (!is_hidden) continue;
    state.reference.ForgetPixel(i);
    state.MarkChanged(state.body[i]);
  }
  state.reference.RefreshGates(state.whole(), state.expected_m);
}

}  // namespace cwm::perception
