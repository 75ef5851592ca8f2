#include "clients/report/scan_page.h"

#include <cstring>
#include <nlohmann/json.hpp>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "clients/cpp/point_labels.h"
#include "proto/transfer/sha256.h"

namespace cwm::report {
namespace {

using nlohmann::json;

std::string Escaped(const std::string& text) {
  return absl::StrReplaceAll(
      text, {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}, {"'", "&#39;"}});
}

// JSON for a script element: "<", which could end the element or begin a comment, is escaped.
// Invalid UTF-8 becomes replacement characters.
std::string ScriptSafe(const json& data) {
  return absl::StrReplaceAll(data.dump(-1, ' ', false, json::error_handler_t::replace),
                             {{"<", "\\u003c"}});
}

// Little-endian numbers for typed arrays of the page.
template <class Number, class Rows>
std::string ColumnBase64(const Rows& rows) {
  std::string bytes;
  bytes.reserve(rows.size() * 3 * sizeof(Number));
  for (const auto& row : rows) {
    for (const auto value : row) {
      const auto number = static_cast<Number>(value);
      bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
    }
  }
  return absl::Base64Escape(bytes);
}

json ToJson(const PackedPoints& points) {
  static constexpr const char* kOwners[] = {"nobody", "support", "object"};
  json runs = json::array();
  for (const PointRun& run : points.runs) {
    const client::PointOwner owner = client::PointOwnerOf(run.label);
    runs.push_back({{"label", run.label},
                    {"owner", kOwners[static_cast<int>(owner.kind)]},
                    {"index", owner.index},
                    {"part", owner.part},
                    {"count", run.count}});
  }
  return {{"measured", points.measured},
          {"every", points.every},
          {"origin_m", points.origin_m},
          {"step_m", points.step_m},
          {"runs", runs},
          {"grid", absl::Base64Escape(points.grid)}};
}

json ToJson(const std::map<std::string, formats::MeshFile>& meshes) {
  json all = json::object();
  for (const auto& [hash, mesh] : meshes) {
    all[hash] = {{"vertices", ColumnBase64<float>(mesh.vertices)},
                 {"triangles", ColumnBase64<std::uint32_t>(mesh.triangles)}};
  }
  return all;
}

json ToJson(const ScanRecord& record) {
  return {{"file", record.file},
          {"made", record.made},
          {"program", record.program},
          {"sensor_model", record.sensor_model},
          {"response", json::parse(record.response_json)},
          {"points", ToJson(record.points)},
          {"meshes", ToJson(record.meshes)}};
}

// Debian's absl has its own string_view.
absl::string_view Text(std::string_view text) { return {text.data(), text.size()}; }

// The 'sha256-...' source of an inline element in a content security policy.
std::string PolicyHash(std::string_view content) {
  return absl::StrCat("'sha256-", absl::Base64Escape(absl::HexStringToBytes(Sha256Hex(content))),
                      "'");
}

std::string Policy(const PageAssets& assets) {
  return absl::StrCat("default-src 'none'; script-src ", PolicyHash(assets.script), "; style-src ",
                      PolicyHash(assets.style), "; base-uri 'none'; form-action 'none'");
}

}  // namespace

std::string FormatScanPage(const ScanRecord& record, const PageAssets& assets) {
  return absl::StrCat(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"",
      Policy(assets),
      "\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<title>",
      Escaped(record.file), " \xC2\xB7 cwm report</title>\n<style>", Text(assets.style),
      "</style>\n</head>\n<body>\n<noscript>The pictures and tables of this page need "
      "JavaScript.</noscript>\n<main id=\"page\"></main>\n"
      "<script type=\"application/json\" id=\"scan\">",
      ScriptSafe(ToJson(record)), "</script>\n<script>", Text(assets.script),
      "</script>\n</body>\n</html>\n");
}

}  // namespace cwm::report
