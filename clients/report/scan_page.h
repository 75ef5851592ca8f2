// A self-contained page that shows the result of a scan.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "clients/formats/mesh_file.h"
#include "clients/report/packed_points.h"

namespace cwm::report {

// The page's script and style as bundled by clients/web; they must not contain closing tags of
// their own elements.
struct PageAssets {
  std::string_view script;
  std::string_view style;
};

struct ScanRecord {
  std::string file;           // the scan's name for people; any UTF-8
  std::string made;           // the time, for people
  std::string program;        // the program that made the page: "cwm 1.2.3"
  std::string sensor_model;   // in the form of the command line
  std::string response_json;  // cwm.v1.IngestCloudResponse as protobuf JSON, snake_case, no labels
  PackedPoints points;
  std::map<std::string, formats::MeshFile> meshes;  // by hash; all that the response names
};

// The whole document. It makes no network requests (its content security policy forbids them) and
// runs only the bundled script.
std::string FormatScanPage(const ScanRecord& record, const PageAssets& assets);

}  // namespace cwm::report
