#include "tests/support/browser.h"

#include <gtest/gtest.h>
#include <png.h>

namespace cwm::testing {
namespace {

// chosen: drawing 300 000 points in software takes seconds, on a busy machine minutes.
constexpr char kPatience_s[] = "400";

ProcessResult Browse(const std::string& action, const std::string& page, const Window& window,
                     const ScratchDirectory& scratch) {
  return RunProgram(
      {"timeout", kPatience_s, "chromium", "--headless=new", "--no-sandbox", "--disable-gpu",
       "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
       "--user-data-dir=" + scratch / "browser", "--force-device-scale-factor=1",
       "--blink-settings=preferredColorScheme=" +
           std::string(window.scheme == ColorScheme::kDark ? "0" : "1"),
       "--window-size=" + std::to_string(window.width_px) + "," + std::to_string(window.height_px),
       action, "file://" + page});
}

Picture ReadPng(const std::string& path) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, path.c_str()) == 0) {
    ADD_FAILURE() << path << ": " << image.message;
    return {};
  }
  image.format = PNG_FORMAT_RGB;
  Picture picture{.width = static_cast<int>(image.width),
                  .height = static_cast<int>(image.height),
                  .pixels = std::vector<Pixel>(std::size_t{image.width} * image.height)};
  static_assert(sizeof(Pixel) == 3);
  if (png_image_finish_read(&image, nullptr, picture.pixels.data(), 0, nullptr) == 0) {
    ADD_FAILURE() << path << ": " << image.message;
    return {};
  }
  return picture;
}

}  // namespace

bool HaveBrowser() { return RunProgram({"sh", "-c", "command -v chromium"}).exit_code == 0; }

std::string DocumentOf(const std::string& page, const Window& window,
                       const ScratchDirectory& scratch) {
  const ProcessResult run = Browse("--dump-dom", page, window, scratch);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return run.out;
}

Picture ScreenshotOf(const std::string& page, const Window& window,
                     const ScratchDirectory& scratch) {
  const std::string file = scratch / "screenshot.png";
  const ProcessResult run = Browse("--screenshot=" + file, page, window, scratch);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return ReadPng(file);
}

}  // namespace cwm::testing
