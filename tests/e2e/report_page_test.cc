// The page of `cwm report` in a browser: the drawing must match the world.
#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "tests/e2e/server_fixture.h"
#include "tests/support/browser.h"

namespace cwm::testing {
namespace {

using nlohmann::json;

constexpr int kUsage = 1;  // exit codes: see `cwm --help`
constexpr int kUnavailable = 2;
constexpr int kBadInput = 8;

// derived: vertices are 32-bit floats, and lengths here are below ten metres: 2^-24 * 10 m, rounded
// up.
constexpr double kFloat_m = 2e-6;

// derived: a circle is drawn with 64 chords, of which a vertex lies on each axis, so its bounds are
// exact.
constexpr double kBounds_m = kFloat_m;

std::int64_t Count(const json& text) { return std::stoll(text.get<std::string>()); }

std::string Content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

Eigen::Isometry3d PoseOf(const json& pose) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Quaterniond(pose.at("qw"), pose.at("qx"), pose.at("qy"), pose.at("qz"))
                   .normalized()
                   .toRotationMatrix();
  X.translation() = Eigen::Vector3d(pose.at("tx_m"), pose.at("ty_m"), pose.at("tz_m"));
  return X;
}

Eigen::Isometry3d PoseOf(const json& object, const char* field) {
  return object.contains(field) && object.at(field).is_object() ? PoseOf(object.at(field))
                                                                : Eigen::Isometry3d::Identity();
}

// The state of a page in the browser once it is drawn.
struct DrawnPage {
  json summary;
  std::string document;

  const json& picture(const std::string& name) const {
    for (const json& picture : summary.at("pictures")) {
      if (picture.at("name") == name) return picture;
    }
    throw std::out_of_range(name);
  }
  // Parts of an object in a picture; `what` is shape, surface or handle.
  std::vector<json> parts(const std::string& picture_name, const std::string& object,
                          const std::string& what) const {
    std::vector<json> found;
    for (const json& part : picture(picture_name).at("parts")) {
      if (part.at("object") == object && part.at("what") == what) found.push_back(part);
    }
    return found;
  }
};

DrawnPage ReadDrawnPage(const std::string& document) {
  const std::string open = "<script type=\"application/json\" id=\"drawn\">";
  const std::size_t begin = document.find(open);
  if (begin == std::string::npos) {
    ADD_FAILURE() << "the page did not draw";
    return {};
  }
  const std::size_t end = document.find("</script>", begin);
  return {json::parse(document.substr(begin + open.size(), end - begin - open.size())), document};
}

class ReportPage : public ServerTest {
 protected:
  void SetUp() override {
    if (!HaveBrowser()) GTEST_SKIP() << "chromium is not installed";
    ServerTest::SetUp();
  }

  // Writes the page of a kitchen scan and ingests the same scan.
  void Report() {
    scan_ = scratch() / "a <b>kitchen & co.pcd";
    std::filesystem::rename(Simulate("kitchen", {"--scene", "kitchen", "--seed", "3"}), scan_);
    page_ = scratch() / "kitchen.html";
    const ProcessResult run = Cwm({"report", scan_, page_});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err, "") << "progress is for terminals";
    ASSERT_LE(RevisionOf("default"), 0) << "a report must leave the world as it is";
    ingest_ = CwmJson({"ingest", scan_});
    const json listed = CwmJson({"objects"});
    for (const json& object : listed.at("objects")) {
      world_[object.at("name")] = object;
    }
    ASSERT_FALSE(world_.empty());
  }

  std::string scan_, page_;
  json ingest_;
  std::map<std::string, json> world_;
};

void ExpectExtent(const json& drawn, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(drawn.at("low").at(k), low[k], kBounds_m) << drawn.dump();
    EXPECT_NEAR(drawn.at("high").at(k), high[k], kBounds_m) << drawn.dump();
  }
}

void ExpectRound(const json& drawn, double radius_low_m, double radius_high_m, double length_m) {
  const double widest_m = std::max(radius_low_m, radius_high_m);
  ExpectExtent(drawn, {-widest_m, -widest_m, -length_m / 2}, {widest_m, widest_m, length_m / 2});
  EXPECT_NEAR(drawn.at("radius_low"), radius_low_m, kFloat_m);
  EXPECT_NEAR(drawn.at("radius_high"), radius_high_m, kFloat_m);
}

void ExpectPlate(const json& drawn, const json& plate) {
  Eigen::Vector3d low(1e9, 1e9, -plate.at("thickness_m").get<double>()), high(-1e9, -1e9, 0);
  for (const json& vertex : plate.at("outline").at("vertices")) {
    const Eigen::Vector2d p(vertex.at("x"), vertex.at("y"));
    low.head<2>() = low.head<2>().cwiseMin(p);
    high.head<2>() = high.head<2>().cwiseMax(p);
  }
  ExpectExtent(drawn, low, high);
}

// Checks the triangles of a part against the shape's dimensions, in the shape's frame.
void ExpectShape(const json& drawn, const json& part) {
  const std::string kind = drawn.at("kind");
  ASSERT_TRUE(part.contains(kind)) << kind << " is drawn of " << part.dump();
  const json& shape = part.at(kind);
  if (kind == "sphere") {
    const Eigen::Vector3d r = Eigen::Vector3d::Constant(shape.at("radius_m"));
    ExpectExtent(drawn, -r, r);
  } else if (kind == "box") {
    const Eigen::Vector3d size(shape.at("size_x_m"), shape.at("size_y_m"), shape.at("size_z_m"));
    ExpectExtent(drawn, -size / 2, size / 2);
  } else if (kind == "cylinder") {
    ExpectRound(drawn, shape.at("radius_m"), shape.at("radius_m"), shape.at("length_m"));
  } else if (kind == "cone") {
    ExpectRound(drawn, shape.at("radius_bottom_m"), shape.at("radius_top_m"), shape.at("length_m"));
  } else {
    ASSERT_EQ(kind, "plate");
    ExpectPlate(drawn, shape);
  }
}

void ExpectPose(const json& drawn, const Eigen::Isometry3d& X_WS) {
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      EXPECT_NEAR(drawn.at("x_world").at(4 * row + column), X_WS.matrix()(row, column), kFloat_m);
    }
  }
}

// A part is hatched exactly where nothing was measured; the top of a support's plate was measured.
void ExpectLook(const json& drawn, const json& part) {
  const bool completed = part.at("role") == "PART_ROLE_COMPLETED";
  const bool measured_top = part.contains("plate") && part.contains("fit");
  const json& transparent = drawn.at("transparent");
  EXPECT_EQ(transparent.at(0), completed && !measured_top) << part.dump();
  EXPECT_EQ(transparent.back(), completed) << part.dump();
}

TEST_F(ReportPage, DrawsEveryObjectAsTheWorldHoldsIt) {
  ASSERT_NO_FATAL_FAILURE(Report());
  const DrawnPage drawn = ReadDrawnPage(DocumentOf(page_, {}, scratch()));
  ASSERT_FALSE(drawn.summary.is_null());
  ASSERT_EQ(world_.size(), ingest_.at("supports").size() + ingest_.at("objects").size());
  std::size_t shapes = 0;
  for (const auto& [name, object] : world_) {
    const Eigen::Isometry3d X_WO = PoseOf(object.at("x_world_object"));
    for (const char* picture : {"shapes", "hybrid"}) {
      const std::vector<json> parts = drawn.parts(picture, name, "shape");
      ASSERT_EQ(parts.size(), object.at("shapes").size()) << name << " in " << picture;
      for (std::size_t i = 0; i < parts.size(); ++i) {
        SCOPED_TRACE(name + ", part " + std::to_string(i) + " in " + picture);
        const json& part = object.at("shapes").at(i);
        ExpectShape(parts[i], part);
        ExpectPose(parts[i], X_WO * PoseOf(part, "x_object_shape"));
        ExpectLook(parts[i], part);
        ++shapes;
      }
    }
  }
  EXPECT_GE(shapes, 2 * 10U) << "nine objects and their support";
}

TEST_F(ReportPage, DrawsEveryMeshAndEveryPoint) {
  ASSERT_NO_FATAL_FAILURE(Report());
  const DrawnPage drawn = ReadDrawnPage(DocumentOf(page_, {}, scratch()));
  ASSERT_FALSE(drawn.summary.is_null());
  for (const auto& [name, object] : world_) {
    for (const char* picture : {"surfaces", "hybrid"}) {
      const std::vector<json> parts = drawn.parts(picture, name, "surface");
      ASSERT_EQ(parts.size(), object.at("surfaces").size()) << name;
      for (std::size_t i = 0; i < parts.size(); ++i) {
        const json& surface = object.at("surfaces").at(i);
        EXPECT_EQ(parts[i].at("hash"), surface.at("hash")) << name;
        EXPECT_EQ(parts[i].at("vertices"), Count(surface.at("vertex_count"))) << name;
        EXPECT_EQ(parts[i].at("triangles"), Count(surface.at("triangle_count"))) << name;
        ExpectPose(parts[i], PoseOf(object.at("x_world_object")));
      }
      EXPECT_EQ(drawn.parts(picture, name, "handle").size(), object.at("handles").size()) << name;
    }
  }
  std::map<std::string, std::int64_t> points;
  std::int64_t all = 0;
  for (const json& run : drawn.picture("segmentation").at("points")) {
    points[run.at("object")] += run.at("count").get<std::int64_t>();
    all += run.at("count").get<std::int64_t>();
  }
  for (const auto& [name, object] : world_) {
    EXPECT_EQ(points[name], Count(object.at("point_count"))) << name;
  }
  EXPECT_EQ(points[""], Count(ingest_.at("report").at("points_rejected")));
  EXPECT_EQ(all, Count(ingest_.at("report").at("points_finite")));
  EXPECT_EQ(drawn.picture("segmentation").at("rendered").at("points"), all);
}

TEST_F(ReportPage, ShowsNamesAsTextAndEveryObjectInItsTable) {
  ASSERT_NO_FATAL_FAILURE(Report());
  const std::string document = DocumentOf(page_, {}, scratch());
  EXPECT_NE(document.find("<h1>a &lt;b&gt;kitchen &amp; co.pcd</h1>"), std::string::npos);
  EXPECT_NE(document.find("<title>a &lt;b&gt;kitchen &amp; co.pcd"), std::string::npos);
  for (const auto& [name, object] : world_) {
    EXPECT_NE(document.find("</span>" + name + "</span>"), std::string::npos) << name;
  }
  // The page's scan is only segmented: no world associates, prepares and publishes it.
  const std::set<std::string> of_worlds = {"association", "geometry", "publish", "keep"};
  for (const json& stage : ingest_.at("stages")) {
    const std::string name = stage.at("stage");
    if (of_worlds.contains(name)) continue;
    EXPECT_NE(document.find("<th scope=\"row\">" + name + "</th>"), std::string::npos) << name;
  }
}

// chosen: a page that can be sent by mail.
TEST_F(ReportPage, IsOneFileOfLessThanEightMegabytes) {
  ASSERT_NO_FATAL_FAILURE(Report());
  EXPECT_LT(std::filesystem::file_size(page_), 8'000'000U);
  const std::string page = Content(page_);
  EXPECT_NE(page.find("http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "),
            std::string::npos);
  EXPECT_EQ(page.find(" src="), std::string::npos) << "nothing is loaded from elsewhere";
  EXPECT_EQ(page.find("<link"), std::string::npos) << "nothing is loaded from elsewhere";
}

struct PaneColors {
  double covered = 0;      // share of pixels that differ from the background
  std::size_t shades = 0;  // different colours, in 32 steps per channel
  std::size_t hues = 0;    // of twelve, among saturated pixels
};

// The twelfth of the colour circle of a saturated pixel; -1 for greys.
int HueOf(const Pixel& p) {
  const int max = std::max({p.r, p.g, p.b}), min = std::min({p.r, p.g, p.b});
  if (max - min < 60) return -1;
  const double chroma = max - min;
  double sixth = 0;
  if (max == p.r) {
    sixth = std::fmod((p.g - p.b) / chroma + 6, 6);
  } else {
    sixth = max == p.g ? (p.b - p.r) / chroma + 2 : (p.r - p.g) / chroma + 4;
  }
  return static_cast<int>(2 * sixth);
}

// The middle of a pane, without its caption and the axes in its corner.
PaneColors PaneColorsOf(const Picture& screen, const json& pane) {
  const int left = pane.at("left").get<int>() + 70, top = pane.at("top").get<int>() + 40;
  const int right = pane.at("left").get<int>() + pane.at("width").get<int>() - 50;
  const int bottom = pane.at("top").get<int>() + pane.at("height").get<int>() - 10;
  const Pixel ground = screen.at(left, bottom - 1);
  std::set<Pixel> shades;
  std::set<int> hues;
  std::int64_t covered = 0;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      const Pixel& p = screen.at(x, y);
      covered += p != ground;
      shades.insert({static_cast<std::uint8_t>(p.r / 8), static_cast<std::uint8_t>(p.g / 8),
                     static_cast<std::uint8_t>(p.b / 8)});
      if (const int hue = HueOf(p); hue >= 0) hues.insert(hue);
    }
  }
  return {.covered = static_cast<double>(covered) / ((right - left) * (bottom - top)),
          .shades = shades.size(),
          .hues = hues.size()};
}

TEST_F(ReportPage, PaintsEveryPictureInLightAndInDark) {
  ASSERT_NO_FATAL_FAILURE(Report());
  Window window{.width_px = 1000, .height_px = 1000};
  const json summary = ReadDrawnPage(DocumentOf(page_, window, scratch())).summary;
  ASSERT_FALSE(summary.is_null());
  std::map<ColorScheme, int> brightness;
  for (const ColorScheme scheme : {ColorScheme::kLight, ColorScheme::kDark}) {
    window.scheme = scheme;
    const Picture screen = ScreenshotOf(page_, window, scratch());
    ASSERT_EQ(screen.width, window.width_px);
    brightness[scheme] = screen.at(2, 2).g;
    ASSERT_EQ(summary.at("pictures").size(), 4U);
    for (const json& pane : summary.at("pictures")) {
      const std::string name = pane.at("name");
      const PaneColors colors = PaneColorsOf(screen, pane);
      EXPECT_GT(colors.covered, 0.05) << name;
      EXPECT_GT(colors.shades, 20U) << name;
      // Nine objects have nine colours; there are few surfaces, and the points around them are
      // grey.
      if (name != "surfaces") {
        EXPECT_GE(colors.hues, 5U) << name;
      }
    }
  }
  EXPECT_GT(brightness[ColorScheme::kLight], 200);
  EXPECT_LT(brightness[ColorScheme::kDark], 60);
}

class ReportCommand : public ServerTest {};

TEST_F(ReportCommand, BeginsItsHelpWithExamples) {
  const ProcessResult help = Cwm({"report", "--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_LT(help.out.find("cwm report scan.pcd scan.html"), help.out.find("--sensor-model"));
}

TEST_F(ReportCommand, SaysWhichFileItCannotReadOrWrite) {
  const std::string page = scratch() / "page.html";
  const ProcessResult missing = Cwm({"report", scratch() / "no.pcd", page});
  EXPECT_EQ(missing.exit_code, kBadInput);
  EXPECT_NE(missing.err.find("no.pcd"), std::string::npos) << missing.err;

  const std::string cloud = Simulate("table", {"--scene", "table", "--seed", "1"});
  const std::string nowhere = scratch() / "no/such/folder/page.html";
  const ProcessResult unwritable = Cwm({"report", cloud, nowhere});
  EXPECT_EQ(unwritable.exit_code, kBadInput);
  EXPECT_NE(unwritable.err.find(nowhere), std::string::npos) << unwritable.err;

  const ProcessResult swapped = Cwm({"report", page, cloud});
  EXPECT_EQ(swapped.exit_code, kUsage);
  EXPECT_NE(swapped.err.find("must end in .html"), std::string::npos) << swapped.err;

  const ProcessResult alone =
      RunProgram({Program("cwm"), "--addr", "unix:" + scratch() / "nobody", "report", cloud, page});
  EXPECT_EQ(alone.exit_code, kUnavailable);
  EXPECT_FALSE(std::filesystem::exists(page));
}

TEST_F(ReportCommand, AnswersProgramsWithWhatTheServerSaid) {
  const std::string cloud = Simulate("table", {"--scene", "table", "--seed", "1"});
  const json answer = CwmJson({"report", cloud, scratch() / "table.html"});
  EXPECT_EQ(answer.at("report").at("points_in"), "307200");
  EXPECT_EQ(answer.at("labels"), "") << "they are in the page";
}

}  // namespace
}  // namespace cwm::testing
