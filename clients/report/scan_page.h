// One self-contained page that shows what a scan came to.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "clients/formats/mesh_file.h"
#include "clients/report/packed_points.h"

namespace cwm::report {

// The page's program and its style as clients/web bundles them; they hold no closing tags of their
// own elements.
struct PageAssets {
  std::string_view script;
  std::string_view style;
};

struct ScanRecord {
  std::string file;           // the scan's name, for people; any UTF-8
  std::string made;           // when, for people
  std::string program;        // who made the page: "cwm 1.2.3"
  std::string sensor_model;   // as the command line takes it
  std::string response_json;  // cwm.v1.IngestCloudResponse as protobuf JSON, snake_case, no labels
  PackedPoints points;
  std::map<std::string, formats::MeshFile> meshes;  // by hash, all that the response names
};

// The whole document. It asks nothing of the network (its content security policy forbids that) and
// runs no script but the bundled one.
std::string FormatScanPage(const ScanRecord& record, const PageAssets& assets);

}  // namespace cwm::report
