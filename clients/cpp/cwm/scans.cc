#include "cwm/scans.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/cpp/cloud_upload.h"
#include "clients/cpp/point_labels.h"
#include "cwm/internal/session.h"
#include "cwm/internal/world_messages.h"
#include "cwm/world.h"

namespace cwm::CWM_API {
namespace {

using internal::ThrowBadArgument;

formats::CloudFile CloudFrom(const World::CloudRef& points, const ScanOptions& options) {
  if (points.cols() == 0) ThrowBadArgument("points", "are none, must be at least one");
  if (options.height < 1 || points.cols() % options.height != 0) {
    ThrowBadArgument("options.height", absl::StrCat("is ", options.height, ", must divide the ",
                                                    points.cols(), " points"));
  }
  const bool has_normals = options.normals.cols() > 0;
  if (has_normals && options.normals.cols() != points.cols()) {
    ThrowBadArgument("options.normals", absl::StrCat("are ", options.normals.cols(), ", must be ",
                                                     points.cols(), " like the points"));
  }
  formats::CloudFile cloud;
  std::vector<std::string> names = {"x", "y", "z"};
  if (has_normals) names.insert(names.end(), {"normal_x", "normal_y", "normal_z"});
  for (const std::string& name : names) cloud.fields.push_back({.name = name});
  cloud.point_step = formats::AssignOffsets(cloud.fields);
  cloud.height = options.height;
  cloud.width = points.cols() / options.height;
  Eigen::MatrixXf rows(static_cast<Eigen::Index>(names.size()), points.cols());
  rows.topRows<3>() = points;
  if (has_normals) rows.bottomRows<3>() = options.normals;
  cloud.bytes.assign(reinterpret_cast<const char*>(rows.data()),
                     static_cast<std::size_t>(rows.size()) * sizeof(float));
  return cloud;
}

v1::IngestCloudHeader HeaderFrom(const std::string& world, const ScanOptions& options) {
  v1::IngestCloudHeader header;
  header.set_world(world);
  header.set_request_id(internal::NewRequestId());
  header.set_sensor(options.sensor_name);
  if (options.X_WS) {
    *header.mutable_x_world_sensor() = internal::ToMessage(*options.X_WS, "options.X_WS");
  }
  if (options.up_S) internal::SetVector(*options.up_S, *header.mutable_up());
  internal::SetSensor(options.sensor, *header.mutable_sensor_model());
  header.set_mode(static_cast<v1::IngestMode>(options.mode));
  header.set_want_point_labels(options.labels);
  v1::IngestOptions& search = *header.mutable_options();
  search.set_search_planes(options.search_planes);
  search.set_search_cylinders(options.search_cylinders);
  search.set_search_spheres(options.search_spheres);
  search.set_search_cones(options.search_cones);
  search.set_clustering(static_cast<v1::Clustering>(options.clustering));
  header.set_frame(static_cast<v1::CloudFrame>(options.frame));
  if (options.viewpoint) internal::SetVector(*options.viewpoint, *header.mutable_viewpoint());
  header.set_scale(options.scale);
  header.set_force(options.force);
  if (options.time_budget_s) {
    *header.mutable_time_budget() =
        internal::DurationFrom(*options.time_budget_s, "options.time_budget_s");
  }
  if (options.expected_revision) header.set_expected_revision(*options.expected_revision);
  return header;
}

template <class Names>
std::vector<std::string> Strings(const Names& names) {
  return {names.begin(), names.end()};
}

}  // namespace

std::vector<Eigen::Index> IngestResult::PointsOf(const std::string& name) const {
  if (labels.empty()) {
    throw Error(ErrorCode::kFailedPrecondition, "labels were not asked for: ScanOptions::labels");
  }
  const auto index_in = [&](const std::vector<Object>& list) {
    const auto found = std::find_if(list.begin(), list.end(), [&](const Object& object) {
      return !name.empty() && object.name == name;
    });
    return found == list.end() ? -1 : static_cast<int>(found - list.begin());
  };
  const int support = index_in(supports), object = index_in(objects);
  if (support < 0 && object < 0) {
    throw Error(ErrorCode::kNotFound,
                absl::StrCat("\"", name, "\" is none of the supports and objects of this scan"));
  }
  const std::uint32_t wanted =
      support >= 0 ? client::SupportLabel(support) : client::ObjectLabel(object);
  const std::uint32_t parts = support >= 0 ? 1 : client::ObjectLabel(1) - client::ObjectLabel(0);
  std::vector<Eigen::Index> points;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] >= wanted && labels[i] < wanted + parts) {
      points.push_back(static_cast<Eigen::Index>(i));
    }
  }
  return points;
}

IngestResult World::Ingest(const CloudRef& points, const ScanOptions& options) const {
  const formats::CloudFile cloud = CloudFrom(points, options);
  const v1::IngestCloudHeader header = HeaderFrom(view().world, options);
  const v1::IngestCloudResponse reply =
      internal::RepeatOrThrow(view(), [&](const client::Connection& connection) {
        return client::IngestCloud(connection, header, cloud);
      });
  IngestResult result{.world_uid = reply.world_uid(), .revision = reply.revision()};
  result.X_WS = internal::FromMessage(reply.x_world_sensor());
  const v1::IngestReport& report = reply.report();
  result.report = {.points_in = report.points_in(),
                   .points_finite = report.points_finite(),
                   .points_explained = report.points_explained(),
                   .points_rejected = report.points_rejected(),
                   .warnings = Strings(report.warnings()),
                   .unchanged_view = report.unchanged_view()};
  for (const v1::Object& support : reply.supports()) {
    result.supports.push_back(internal::FromMessage(support));
  }
  for (const v1::Object& object : reply.objects()) {
    result.objects.push_back(internal::FromMessage(object));
  }
  const v1::IngestChanges& changes = reply.changes();
  result.changes = {.added = Strings(changes.added()),
                    .moved = Strings(changes.moved()),
                    .replaced = Strings(changes.replaced()),
                    .removed = Strings(changes.removed()),
                    .kept = Strings(changes.kept()),
                    .occluded = Strings(changes.occluded())};
  for (const v1::StageTime& stage : reply.stages()) {
    result.stages_ms.emplace_back(stage.stage(), stage.elapsed_ms());
  }
  if (options.labels && (!reply.labels().empty() || !reply.labels_hash().empty())) {
    result.labels = internal::RepeatOrThrow(view(), [&](const client::Connection& connection) {
      return client::ReadLabels(connection, reply, points.cols());
    });
  }
  return result;
}

}  // namespace cwm::CWM_API
