// Measures the robot in view alone, on a simulated Panda whose hand sweeps over things at 0.6 m/s:
// pixels of the robot that are left in the world by margin and by lateness of the state, frames in
// which more than a few are, things beside the hand that are kept, and the time of a frame.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "tests/benchmarks/live/panda_sweep.h"

namespace cwm::benchmarks {
namespace {

constexpr double kFrameTime_s = 1.0 / 30;
// chosen: a frame with more pixels of the robot than this in the world has failed.
constexpr int kMaxLeftPixels = 8;
// chosen: a thing is near the hand within this distance, and still there if most of its pixels are.
constexpr double kNearHand_m = 0.03;
constexpr double kKeptShare = 0.5;

double ThreadTime_s() {
  timespec now = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Counts of true pixels by what the masks of frames made of them.
struct Tally {
  long frames = 0;
  long robot_pixels = 0;
  long left = 0;           // of the robot, without a class
  long unmasked = 0;       // of these, those that no known surface explains
  long mixed_left = 0;     // between two surfaces, near the robot, without a class and unexplained
  long failed_frames = 0;  // more than kMaxLeftPixels of them
  long frames_left = 0;    // the same of all pixels left
  long near_things = 0, near_kept = 0;
  long near_pixels = 0, near_pixels_kept = 0;
  long wrong_frames = 0;
  std::vector<double> through = {};  // the largest number of pixels through a link
  std::vector<double> share = {};
  std::vector<double> ms = {};
};

struct Setting {
  perception::RobotMargins margins = {};
  double state_offset_s = 0;  // of the state that is used from the frame's time
  double told_late_s = 0;
  bool with_expected = true;
};

bool IsExplained(const PandaSweep& sweep, std::size_t pixel, float depth_m) {
  const double sigma_m =
      std::hypot(sweep.noise().AxialSigma_m(depth_m), sweep.noise().WarpSigma_m());
  return std::abs(depth_m - sweep.expected_m()[pixel]) <= perception::kGate_sigma * sigma_m;
}

// True if a pixel within the scanner's reach of mixed depths shows the robot.
bool IsBesideRobot(const PandaSweep& sweep, const SweepFrame& frame, std::size_t pixel) {
  constexpr int kReach_px = 3;
  const int width = frame.image.width;
  const int u = static_cast<int>(pixel) % width, v = static_cast<int>(pixel) / width;
  for (int dv = -kReach_px; dv <= kReach_px; ++dv) {
    for (int du = -kReach_px; du <= kReach_px; ++du) {
      const bool is_inside =
          u + du >= 0 && u + du < width && v + dv >= 0 && v + dv < frame.image.height;
      const std::size_t other = pixel + static_cast<std::size_t>(dv * width + du);
      if (is_inside && sweep.IsRobot(frame.object[other])) return true;
    }
  }
  return false;
}

void Count(const PandaSweep& sweep, const SweepFrame& frame, const Setting& setting,
           const std::vector<double>& hand_m, perception::RobotView& view, Tally& tally) {
  const std::vector<perception::LinkAtStamp> links =
      sweep.LinksAt(frame.time_s + setting.state_offset_s);
  perception::RobotFrame seen{.camera = &sweep.camera(),
                              .X_WC = sweep.X_WC(),
                              .image = &frame.image,
                              .noise = sweep.noise()};
  if (setting.with_expected) {
    seen.expected_m = sweep.expected_m();
    seen.expected_body = sweep.expected_body();
  }
  const double start_s = ThreadTime_s();
  const perception::RobotSighting sighting =
      view.Mask(seen,
                {.source = perception::StateSource::kInterpolated,
                 .late_s = setting.told_late_s,
                 .links = links},
                {}, setting.margins);
  tally.ms.push_back(1e3 * (ThreadTime_s() - start_s));
  ++tally.frames;
  tally.through.push_back(sighting.through_pixels);
  tally.share.push_back(100 * sighting.through_share);
  if (sighting.fault == perception::RobotStateFault::kWrong) ++tally.wrong_frames;
  std::vector<long> shown(hand_m.size()), kept(hand_m.size());
  long left = 0, unmasked = 0;
  for (std::size_t pixel = 0; pixel < frame.object.size(); ++pixel) {
    const std::int32_t object = frame.object[pixel];
    const std::uint8_t of_pixel = sighting.mask.empty() ? 0 : sighting.mask.pixels[pixel];
    const float depth_m = frame.image.depth_m[pixel];
    if (depth_m == 0) continue;
    if (object == perception::kMixedPixel) {
      if (of_pixel == 0 && !IsExplained(sweep, pixel, depth_m) &&
          IsBesideRobot(sweep, frame, pixel)) {
        ++tally.mixed_left;
      }
    } else if (sweep.IsRobot(object)) {
      ++tally.robot_pixels;
      if (of_pixel != 0) continue;
      ++left;
      if (!IsExplained(sweep, pixel, depth_m)) ++unmasked;
    } else if (object >= 0) {
      ++shown[static_cast<std::size_t>(object)];
      if (of_pixel == 0) ++kept[static_cast<std::size_t>(object)];
    }
  }
  tally.left += left;
  tally.unmasked += unmasked;
  if (left > kMaxLeftPixels) ++tally.frames_left;
  if (unmasked > kMaxLeftPixels) ++tally.failed_frames;
  for (std::size_t i = 1; i < hand_m.size(); ++i) {  // 0 is the table
    if (hand_m[i] > kNearHand_m || shown[i] < 20) continue;
    ++tally.near_things;
    if (static_cast<double>(kept[i]) >= kKeptShare * static_cast<double>(shown[i])) {
      ++tally.near_kept;
    }
    tally.near_pixels += shown[i];
    tally.near_pixels_kept += kept[i];
  }
}

double Percent(long part, long all) {
  return all == 0 ? 0 : 100.0 * static_cast<double>(part) / static_cast<double>(all);
}

double QuantileOf(std::vector<double> values, double p) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(p * static_cast<double>(values.size() - 1))];
}

void Print(const char* name, const Tally& tally) {
  std::printf(
      "%s: %ld frames, %ld robot pixels a frame, left %.4f %% (%.4f %% unexplained), mixed left "
      "%.1f a frame, frames with > %d unexplained %ld (any left: %ld), near things kept %ld of %ld "
      "(%.2f %%), "
      "their pixels kept %.1f %%, told wrong %ld, through p50 %.0f p95 %.0f max %.0f px p95 %.1f "
      "%%, ms p50 %.2f p95 %.2f\n",
      name, tally.frames, tally.robot_pixels / tally.frames,
      Percent(tally.left, tally.robot_pixels), Percent(tally.unmasked, tally.robot_pixels),
      static_cast<double>(tally.mixed_left) / static_cast<double>(tally.frames), kMaxLeftPixels,
      tally.failed_frames, tally.frames_left, tally.near_kept, tally.near_things,
      Percent(tally.near_kept, tally.near_things),
      Percent(tally.near_pixels_kept, tally.near_pixels), tally.wrong_frames,
      QuantileOf(tally.through, 0.5), QuantileOf(tally.through, 0.95), QuantileOf(tally.through, 1),
      QuantileOf(tally.share, 0.95), QuantileOf(tally.ms, 0.5), QuantileOf(tally.ms, 0.95));
}

// Every margin and lateness on the same frames; lateness is not told.
void MeasureMargins(const PandaSweep& sweep, int frames) {
  constexpr std::array<double, 5> kLate_s = {0, 0.005, 0.02, 0.033, 0.066};
  constexpr std::array<double, 4> kMargins_m = {0.01, 0.02, 0.03, 0.05};
  std::array<std::array<Tally, 5>, 5> tallies;
  perception::RobotView view(sweep.surface());
  for (int i = 0; i < frames; ++i) {
    const SweepFrame frame = sweep.Frame(7.3 * kFrameTime_s * i, static_cast<std::uint64_t>(i) + 1);
    const std::vector<double> hand_m = sweep.HandDistances_m(frame);
    for (std::size_t late = 0; late < kLate_s.size(); ++late) {
      Setting setting;
      setting.state_offset_s = -kLate_s[late];
      setting.margins.clock_s = 0;
      for (std::size_t margin = 0; margin < kMargins_m.size(); ++margin) {
        setting.margins.calibration_m = kMargins_m[margin];
        Count(sweep, frame, setting, hand_m, view, tallies[late][margin]);
      }
      // As a server does it: the default margin, and the lateness is told.
      setting.margins = {};
      setting.told_late_s = kLate_s[late];
      Count(sweep, frame, setting, hand_m, view, tallies[late].back());
    }
  }
  for (std::size_t late = 0; late < kLate_s.size(); ++late) {
    for (std::size_t margin = 0; margin <= kMargins_m.size(); ++margin) {
      char name[80];
      if (margin < kMargins_m.size()) {
        std::snprintf(name, sizeof(name), "late %2.0f ms, margin %2.0f mm", 1e3 * kLate_s[late],
                      1e3 * kMargins_m[margin]);
      } else {
        std::snprintf(name, sizeof(name), "late %2.0f ms, 20 mm and told", 1e3 * kLate_s[late]);
      }
      Print(name, tallies[late][margin]);
    }
  }
}

// Frames in a row, with stamps that are wrong by up to 5 ms.
void MeasureFrames(const PandaSweep& sweep, int frames) {
  Tally with, without, exact_margin;
  perception::RobotView view(sweep.surface());
  for (int i = 0; i < frames; ++i) {
    const SweepFrame frame = sweep.Frame(kFrameTime_s * i, static_cast<std::uint64_t>(i) + 1);
    const std::vector<double> hand_m = sweep.HandDistances_m(frame);
    Setting setting;
    setting.state_offset_s = 0.005 * std::sin(2.4 * i);
    Count(sweep, frame, setting, hand_m, view, with);
    setting.with_expected = false;
    Count(sweep, frame, setting, hand_m, view, without);
    setting.with_expected = true;
    setting.margins.clock_s = 0;
    Count(sweep, frame, setting, hand_m, view, exact_margin);
  }
  Print("stamps within 5 ms, known surfaces given", with);
  Print("stamps within 5 ms, none given", without);
  Print("stamps within 5 ms, margin without motion", exact_margin);
}

}  // namespace
}  // namespace cwm::benchmarks

int main(int argc, char** argv) {
  const std::string part = argc > 1 ? argv[1] : "";
  const int frames = argc > 2 ? std::atoi(argv[2]) : 100;
  if ((part != "margins" && part != "frames") || frames < 1) {
    std::puts("cwm-bench-robot-view margins|frames [FRAMES]");
    return part == "--help" ? 0 : 1;
  }
  const auto sweep = cwm::benchmarks::PandaSweep::Read();
  if (!sweep) {
    std::puts("motion_bench_maker is not in CWM_DATA");
    return 1;
  }
  if (part == "margins") {
    cwm::benchmarks::MeasureMargins(*sweep, frames);
  } else {
    cwm::benchmarks::MeasureFrames(*sweep, frames);
  }
}
