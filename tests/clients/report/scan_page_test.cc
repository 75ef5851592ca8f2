#include "clients/report/scan_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "absl/strings/escaping.h"
#include "proto/transfer/sha256.h"

namespace cwm::report {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr PageAssets kAssets = {.script = "build();", .style = "p{color:red}"};

ScanRecord RecordOf(const std::string& file) {
  return {.file = file,
          .made = "2026-01-02T03:04:05Z",
          .program = "cwm 1.2.3",
          .sensor_model = "kinect",
          .response_json = R"({"supports": [], "objects": [{"name": "<!-- a & b -->"}]})",
          .points = {.origin_m = {0, 0, 1}, .step_m = 1e-4, .runs = {{23, 1}}, .grid = "abcdef"},
          .meshes = {{"beef", {.vertices = {{0, 0.5, 1}}, .triangles = {{0, 1, 2}}}}}};
}

json DataOf(const std::string& page) {
  const std::string open = "<script type=\"application/json\" id=\"scan\">";
  const std::size_t begin = page.find(open) + open.size();
  return json::parse(page.substr(begin, page.find("</script>", begin) - begin));
}

TEST(ScanPage, CarriesTheScanAsJson) {
  const json data = DataOf(FormatScanPage(RecordOf("kitchen.pcd"), kAssets));
  EXPECT_EQ(data.at("file"), "kitchen.pcd");
  EXPECT_EQ(data.at("program"), "cwm 1.2.3");
  EXPECT_EQ(data.at("response").at("objects").at(0).at("name"), "<!-- a & b -->");
  const json run = data.at("points").at("runs").at(0);
  EXPECT_EQ(run, json::parse(R"({"label": 23, "owner": "object", "index": 0, "part": 3,
                                 "count": 1})"));
  EXPECT_EQ(data.at("points").at("grid"), absl::Base64Escape("abcdef"));
  const float vertex[3] = {0, 0.5F, 1};
  EXPECT_EQ(data.at("meshes").at("beef").at("vertices"),
            absl::Base64Escape({reinterpret_cast<const char*>(vertex), sizeof(vertex)}));
  const std::uint32_t triangle[3] = {0, 1, 2};
  EXPECT_EQ(data.at("meshes").at("beef").at("triangles"),
            absl::Base64Escape({reinterpret_cast<const char*>(triangle), sizeof(triangle)}));
}

TEST(ScanPage, LetsNoNameBreakOutOfItsPlace) {
  for (const std::string& name :
       {std::string("</script><script>alert(1)</script>.pcd"), std::string("<!--<script>.pcd"),
        std::string("\"><img src=x>&amp;.pcd"), std::string("Küche \xE2\x82\xAC.pcd")}) {
    const std::string page = FormatScanPage(RecordOf(name), kAssets);
    EXPECT_EQ(DataOf(page).at("file"), name);
    // Only the bundled script and the data; nothing of the name is markup.
    const std::regex script("<script");
    EXPECT_EQ(std::distance(std::sregex_iterator(page.begin(), page.end(), script), {}), 2) << page;
    EXPECT_THAT(page, Not(HasSubstr("<img")));
    EXPECT_THAT(page, Not(HasSubstr("<!--")));
  }
}

TEST(ScanPage, ReplacesBytesOfANameThatAreNoUtf8) {
  const std::string page = FormatScanPage(RecordOf("a\xFF.pcd"), kAssets);
  EXPECT_EQ(DataOf(page).at("file"), "a\xEF\xBF\xBD.pcd");
}

TEST(ScanPage, AllowsItsOwnScriptAndStyleAndNoRequests) {
  const std::string page = FormatScanPage(RecordOf("kitchen.pcd"), kAssets);
  const auto hash = [](std::string_view content) {
    return "'sha256-" + absl::Base64Escape(absl::HexStringToBytes(Sha256Hex(content))) + "'";
  };
  EXPECT_THAT(page, HasSubstr("content=\"default-src 'none'; script-src " + hash(kAssets.script) +
                              "; style-src " + hash(kAssets.style) + "; "));
  EXPECT_THAT(page, HasSubstr("<script>build();</script>"));
  EXPECT_THAT(page, HasSubstr("<style>p{color:red}</style>"));
}

}  // namespace
}  // namespace cwm::report
