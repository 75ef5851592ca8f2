#include "clients/cli/scan_report.h"

#include <ostream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cli/object_table.h"
#include "clients/cli/quantity.h"
#include "clients/cpp/point_labels.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using NameList = google::protobuf::RepeatedPtrField<std::string>;

void PrintNames(const std::string& what, const NameList& names, std::ostream& out) {
  if (!names.empty()) out << what << ": " << absl::StrJoin(names, ", ") << "\n";
}

void PrintCounts(const pb::IngestReport& report, std::ostream& out) {
  out << report.points_in() << " points, " << report.points_finite() << " measured, "
      << report.points_explained() << " explained";
  if (report.points_finite() > 0) {
    out << " ("
        << FormatPercent(static_cast<double>(report.points_explained()) /
                         static_cast<double>(report.points_finite()))
        << ")";
  }
  out << ", " << report.points_rejected() << " rejected\n";
  if (report.unchanged_view()) out << "the view did not change: nothing was interpreted\n";
  for (const std::string& warning : report.warnings()) out << "warning: " << warning << "\n";
}

void PrintChanges(const pb::IngestChanges& changes, std::ostream& out) {
  PrintNames("added", changes.added(), out);
  PrintNames("moved", changes.moved(), out);
  PrintNames("replaced", changes.replaced(), out);
  PrintNames("removed", changes.removed(), out);
  PrintNames("kept", changes.kept(), out);
  PrintNames("occluded", changes.occluded(), out);
}

void PrintStages(const google::protobuf::RepeatedPtrField<pb::StageTime>& stages,
                 std::ostream& out) {
  if (stages.empty()) return;
  double total_ms = 0;
  std::string text;
  for (const pb::StageTime& stage : stages) {
    absl::StrAppend(&text, text.empty() ? "" : ", ", stage.stage(), " ",
                    FormatFixed(stage.elapsed_ms(), 1));
    total_ms += stage.elapsed_ms();
  }
  out << "stages (ms): " << text << "; together " << FormatFixed(total_ms, 1) << "\n";
}

}  // namespace

void PrintScanReport(const pb::IngestCloudResponse& response, TableStyle style, std::ostream& out) {
  PrintCounts(response.report(), out);
  out << "sensor in the world: " << FormatPose(response.x_world_sensor()) << "\n";
  PrintChanges(response.changes(), out);
  std::vector<LabelledObject> objects;
  for (int i = 0; i < response.supports_size(); ++i) {
    objects.push_back({&response.supports(i), static_cast<int>(client::SupportLabel(i))});
  }
  for (int i = 0; i < response.objects_size(); ++i) {
    objects.push_back({&response.objects(i), static_cast<int>(client::ObjectLabel(i))});
  }
  PrintObjects(objects, style, out);
  PrintStages(response.stages(), out);
  out << "revision " << response.revision() << "\n";
}

}  // namespace cwm::cli
