#include "server/core/unchanged_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "perception/cloud/returns.h"
#include "perception/track/range_view.h"

namespace cwm::server {
namespace {

using collision::ObjectKind;
using collision::WorldObject;
using collision::WorldObjectPtr;
using perception::DepthCamera;
using perception::DepthImage;
using perception::IsReturn;
using perception::PointCloud;

// chosen: what is further outside of the image is not in the view.
constexpr double kBorder_px = 8;
// The share of points that an interpretation may leave without an object.
constexpr double kMaxRejectedShare = 0.005;
constexpr std::uint32_t kLabelsPerObject = 10;

ViewConditions ConditionsOf(const IngestRequest& request, const SensorPose& pose) {
  return {.pose = pose,
          .in_world_frame = request.in_world_frame,
          .mode = request.mode,
          .viewpoint_C = request.viewpoint_C,
          .options = request.options,
          .width = request.cloud.width,
          .height = request.cloud.height,
          .seen_from_origin = request.cloud.seen_from_origin};
}

// The depths of an organised cloud, if its points lie on the rays of the camera's pixels to one
// pixel (rms), as EstimatePinhole demands.
std::shared_ptr<const DepthImage> ImageOf(const PointCloud& cloud, const DepthCamera& camera) {
  auto image = std::make_shared<DepthImage>();
  image->width = camera.width;
  image->height = camera.height;
  image->depth_m.assign(cloud.points.size(), 0);
  const auto focal_u = static_cast<float>(camera.pinhole.focal_u_px);
  const auto focal_v = static_cast<float>(camera.pinhole.focal_v_px);
  const auto center_u = static_cast<float>(camera.pinhole.center_u_px);
  const auto center_v = static_cast<float>(camera.pinhole.center_v_px);
  double sum_u_px2 = 0;
  double sum_v_px2 = 0;
  std::int64_t returns = 0;
  std::size_t i = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u, ++i) {
      const Eigen::Vector3f& p = cloud.points[i];
      if (!IsReturn(p)) continue;
      if (p.z() <= 0) return nullptr;
      const float off_u_px = focal_u * p.x() / p.z() + center_u - static_cast<float>(u);
      const float off_v_px = focal_v * p.y() / p.z() + center_v - static_cast<float>(v);
      sum_u_px2 += off_u_px * off_u_px;
      sum_v_px2 += off_v_px * off_v_px;
      ++returns;
      image->depth_m[i] = p.z();
    }
  }
  const auto most = static_cast<double>(returns);
  return sum_u_px2 < most && sum_v_px2 < most ? image : nullptr;
}

std::optional<DepthCamera> CameraOf(const IngestRequest& request) {
  const PointCloud& cloud = request.cloud;
  if (!cloud.seen_from_origin || !cloud.normals.empty()) return std::nullopt;
  const auto pinhole = perception::EstimatePinhole(cloud);
  if (!pinhole.has_value()) return std::nullopt;
  const perception::WorkingRange range = perception::RangeOf(request.options.noise.model);
  return DepthCamera{.pinhole = *pinhole,
                     .width = cloud.width,
                     .height = cloud.height,
                     .least_range_m = static_cast<float>(range.nearest_m),
                     .greatest_range_m = static_cast<float>(range.farthest_m)};
}

bool SameBits(const std::vector<Eigen::Vector3f>& a, const std::vector<Eigen::Vector3f>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(a.front())) == 0);
}

// Half-spaces that hold all that a camera sees.
class Frustum {
 public:
  // The camera is in the frame V of the viewpoint.
  Frustum(const DepthCamera& camera, const Pose& X_WV) : X_VW_(X_WV.inverse()) {
    const perception::Pinhole& of = camera.pinhole;
    const double right = camera.width - of.center_u_px + kBorder_px;
    const double lower = camera.height - of.center_v_px + kBorder_px;
    inward_V_ = {Vector3(of.focal_u_px, 0, of.center_u_px + kBorder_px),
                 Vector3(-of.focal_u_px, 0, right),
                 Vector3(0, of.focal_v_px, of.center_v_px + kBorder_px),
                 Vector3(0, -of.focal_v_px, lower), Vector3(0, 0, 1)};
  }

  // False only if nothing of the box is inside.
  bool MayHold(const Aabb& box_W) const {
    if (box_W.isEmpty()) return true;
    std::array<Vector3, 8> corners_V;
    for (int k = 0; k < 8; ++k) {
      corners_V[static_cast<std::size_t>(k)] =
          X_VW_ * box_W.corner(static_cast<Aabb::CornerType>(k));
    }
    return std::ranges::all_of(inward_V_, [&](const Vector3& inward_V) {
      return std::ranges::any_of(corners_V,
                                 [&](const Vector3& p_V) { return inward_V.dot(p_V) >= 0; });
    });
  }

 private:
  Pose X_VW_;
  std::array<Vector3, 5> inward_V_;
};

bool IsNamed(const KeptView& view, const std::string& name) {
  for (const auto* names : {&view.support_names, &view.object_names, &view.seen, &view.occluded}) {
    if (std::ranges::find(*names, name) != names->end()) return true;
  }
  return false;
}

// The objects that an interpretation of the view may be about, by name. Without an image all may
// be.
std::vector<WorldObjectPtr> ObjectsInView(const collision::WorldSnapshot& world,
                                          const KeptView& view) {
  std::optional<Frustum> frustum;
  if (view.image) {
    frustum.emplace(view.image->camera(),
                    view.X_WC * Eigen::Translation3d(view.conditions.viewpoint_C));
  }
  std::vector<WorldObjectPtr> objects;
  for (const WorldObjectPtr& object : world.objects()) {
    if (object->kind == ObjectKind::kUnseen || object->kind == ObjectKind::kMover) continue;
    const bool may_be =
        !frustum || frustum->MayHold(object->bounds_W) || IsNamed(view, object->name);
    if (may_be) objects.push_back(object);
  }
  return objects;
}

std::vector<std::string> NamesOf(const std::vector<WorldObjectPtr>& objects,
                                 std::vector<WorldObjectPtr>& provisional) {
  std::vector<std::string> names;
  for (const WorldObjectPtr& object : objects) {
    const bool is_of_world = object != nullptr && object->create_revision.value != 0;
    names.push_back(is_of_world ? object->name : "");
    provisional.push_back(is_of_world ? nullptr : object);
  }
  return names;
}

// Calls use(label, count) for each run of equal labels but 0: neighbours mostly have the same.
template <class Use>
void ForEachRun(const std::vector<std::uint32_t>& labels, const Use& use) {
  for (std::size_t i = 0; i < labels.size();) {
    const std::size_t begin = i;
    while (i < labels.size() && labels[i] == labels[begin]) ++i;
    if (labels[begin] != 0) use(labels[begin], static_cast<std::int64_t>(i - begin));
  }
}

// True if each object, and all supports together, keep at least half of their points.
bool KeepsObjects(const std::vector<std::uint32_t>& before, const std::vector<std::uint32_t>& now) {
  if (before.empty()) return true;
  const std::uint32_t greatest = std::max(*std::ranges::max_element(before), 1U);
  // By object: the points now beyond a half of those before, twice. Every label is one of before.
  std::vector<std::int64_t> margins(greatest / kLabelsPerObject + 1, 0);
  ForEachRun(before, [&](std::uint32_t label, std::int64_t count) {
    margins[label / kLabelsPerObject] -= count;
  });
  ForEachRun(now, [&](std::uint32_t label, std::int64_t count) {
    margins[label / kLabelsPerObject] += 2 * count;
  });
  return std::ranges::all_of(margins, [](std::int64_t margin) { return margin >= 0; });
}

// The labels of the scan's points. Empty if it shows something else.
std::optional<std::vector<std::uint32_t>> LabelsOf(const KeptView& view, const PointCloud& cloud) {
  if (!view.image) {
    if (!SameBits(view.points, cloud.points) || !SameBits(view.normals, cloud.normals)) return {};
    return view.labels;
  }
  if (!cloud.normals.empty() || cloud.points.size() != view.labels.size()) return {};
  const auto image = ImageOf(cloud, view.image->camera());
  if (image == nullptr) return {};
  const auto sources = view.image->Match(*image);
  if (!sources) return {};
  std::vector<std::uint32_t> labels(sources->size(), 0);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const std::int32_t source = (*sources)[i];
    if (source >= 0) labels[i] = view.labels[static_cast<std::size_t>(source)];
  }
  if (!KeepsObjects(view.labels, labels)) return {};
  return labels;
}

// The counts of the scan; its explained points as the share of those that are of an object.
perception::InterpretReport ReportOf(const KeptView& view, const PointCloud& cloud,
                                     const std::vector<std::uint32_t>& labels) {
  perception::InterpretReport report = view.report;
  report.points_in = cloud.points.size();
  report.points_finite = 0;
  report.points_rejected = 0;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (!IsReturn(cloud.points[i])) continue;
    ++report.points_finite;
    if (labels[i] == 0) ++report.points_rejected;
  }
  const auto labelled = [](const perception::InterpretReport& of) {
    return static_cast<double>(of.points_finite - of.points_rejected);
  };
  const double share =
      labelled(view.report) > 0
          ? static_cast<double>(view.report.points_explained) / labelled(view.report)
          : 0;
  report.points_explained = static_cast<std::uint64_t>(std::llround(share * labelled(report)));
  return report;
}

bool RejectsMore(const perception::InterpretReport& now, const perception::InterpretReport& then) {
  const double most = kMaxRejectedShare * static_cast<double>(now.points_finite);
  return static_cast<double>(now.points_rejected) >
         static_cast<double>(then.points_rejected) + most;
}

}  // namespace

KeptViewPtr MakeKeptView(const IngestRequest& request, const SensorPose& pose,
                         const IngestOutcome& outcome, const perception::InterpretReport& report,
                         const SnapshotsOfScan& worlds) {
  if (request.cloud.points.size() > KeptViews::kMaxPoints) return nullptr;
  KeptView view{.sensor = request.sensor, .conditions = ConditionsOf(request, pose)};
  // Functions of the request may refer to it.
  view.conditions.options.threads_now = {};
  view.conditions.options.on_chunk = {};
  std::shared_ptr<const DepthImage> image;
  const std::optional<DepthCamera> camera = CameraOf(request);
  if (camera) image = ImageOf(request.cloud, *camera);
  if (image != nullptr) {
    view.image.emplace(*camera, request.options.noise, std::move(image));
  } else {
    view.points = request.cloud.points;
    view.normals = request.cloud.normals;
  }
  view.X_WC = outcome.X_WC;
  view.report = report;
  view.report.stages.clear();
  view.labels = outcome.labels;
  view.support_names = NamesOf(outcome.supports, view.provisional);
  view.object_names = NamesOf(outcome.objects, view.provisional);
  view.support_reachable = outcome.support_reachable;
  for (const auto* names : {&outcome.added, &outcome.moved, &outcome.replaced, &outcome.kept}) {
    view.seen.insert(view.seen.end(), names->begin(), names->end());
  }
  view.occluded = outcome.occluded;
  if (worlds.matched != worlds.changed &&
      ObjectsInView(*worlds.matched, view) != ObjectsInView(*worlds.changed, view)) {
    return nullptr;
  }
  for (const WorldObjectPtr& object : ObjectsInView(*worlds.after, view)) {
    view.in_view.push_back(object);
  }
  return std::make_shared<const KeptView>(std::move(view));
}

bool HoldsAsSeen(const collision::WorldSnapshot& world, const KeptView& view) {
  return std::ranges::equal(
      ObjectsInView(world, view), view.in_view,
      [](const WorldObjectPtr& now, const std::weak_ptr<const WorldObject>& then) {
        return now == then.lock();
      });
}

std::optional<IngestOutcome> MatchUnchanged(const KeptView& view, const IngestRequest& request,
                                            const SensorPose& pose,
                                            const collision::WorldSnapshot& world) {
  if (!(view.conditions == ConditionsOf(request, pose))) return std::nullopt;
  if (!HoldsAsSeen(world, view)) return std::nullopt;
  auto labels = LabelsOf(view, request.cloud);
  if (!labels) return std::nullopt;
  IngestOutcome outcome;
  outcome.report = ReportOf(view, request.cloud, *labels);
  if (RejectsMore(outcome.report, view.report)) return std::nullopt;
  outcome.unchanged_view = true;
  outcome.X_WC = view.X_WC;
  outcome.labels = *std::move(labels);
  std::size_t next = 0;
  const auto resolve = [&](const std::vector<std::string>& names,
                           std::vector<WorldObjectPtr>& objects) {
    for (const std::string& name : names) {
      const WorldObjectPtr& provisional = view.provisional[next++];
      objects.push_back(provisional != nullptr ? provisional : world.Find(name));
    }
  };
  resolve(view.support_names, outcome.supports);
  resolve(view.object_names, outcome.objects);
  outcome.support_reachable = view.support_reachable;
  outcome.kept = view.seen;
  outcome.occluded = view.occluded;
  return outcome;
}

WriteFacts SightingsOf(const KeptView& view, const IngestRequest& request) {
  WriteFacts facts;
  for (const std::string& name : view.seen) facts.sightings.push_back({.name = name});
  for (std::size_t i = 0; i < view.support_names.size(); ++i) {
    for (Sighting& sighting : facts.sightings) {
      if (sighting.name == view.support_names[i]) sighting.reachable = view.support_reachable[i];
    }
  }
  facts.seen_at = request.taken_at();
  if (request.options.X_WC.has_value() && !request.in_world_frame) {
    facts.sensor_pose = NamedSensorPose{request.sensor, view.conditions.pose};
  }
  return facts;
}

}  // namespace cwm::server
