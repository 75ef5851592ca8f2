// The figures of `./dev bench live`: worlds that follow running sensors, through a server of their
// own and over gRPC. Sensors are simulated Kinects of 640 x 480 pixels at 30 Hz, unless said
// otherwise, whose frames are rendered before they are sent.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/benchmarks/live/scene_samples.h"
#include "tests/benchmarks/report.h"

namespace cwm::benchmarks {

// The median of the yardstick on this machine in this run, measured by the first call:
// live_yardstick_ms. Empty without liboctomap-dev.
std::optional<double> Yardstick_ms(Report& report);
void MeasureLiveYardstick(Report& report);

// One pushed thing, from the last byte of a frame to the revision that a query sees:
// live_change_p50_ms, live_change_p95_ms.
void MeasureLiveChange(Report& report);

// Rates without dropped frames while nothing changes: live_static_fps_1, live_static_fps_3.
void MeasureLiveStatic(Report& report);

// 3 000 frames in which nothing changes: live_static_revisions.
void MeasureLiveRevisions(Report& report);

// Processor time of a frame by its share of changed pixels: live_cpu_ms_0, _2, _5, _20, and with
// 200 known objects live_cpu_known_ratio.
void MeasureLiveCpu(Report& report);

// Things that jump, vanish and come back, against the truth: live_notice_ms_added, _removed,
// _moved_20, _moved_5, _moved_2, live_rest_error_mm, live_rest_error_p95_mm, live_rest_jitter,
// live_false_changes, live_id_switches, live_names_kept.
void MeasureLiveTruth(const SceneOptions& options, Report& report);

// A hand that takes, puts and pushes things: live_movers_covered, live_movers_excess,
// live_movers_gone_ms, live_movers_shapes, live_hand_false_changes.
void MeasureLiveHand(Report& report);

// A robot whose hand sweeps over the things: live_arm_frames, live_arm_things_kept,
// live_false_removals_hidden.
void MeasureLiveArm(const SceneOptions& options, Report& report);

// Three sensors beside queries and writes: live_three_sensors_p95_ms, live_query_p99_ratio,
// live_put_p99_ms.
void MeasureLiveLoad(Report& report);

// Real sequences, where CWM_DATA has them: live_static_revisions_real, live_false_changes_real,
// live_real_inserted, live_moving_camera_changes.
void MeasureLiveReal(Report& report);

// Three views of one table against the best of them: fusion_gain, fusion_radius_ratio,
// fusion_twice.
void MeasureLiveFusion(const SceneOptions& options, Report& report);

// Late, doubled, swapped and lost frames against the processed ones alone: live_order.
void MeasureLiveOrder(const SceneOptions& options, Report& report);

// Traces of three sensors that stream at once, replayed: live_order_sensors.
void MeasureLiveTrace(const SceneOptions& options, Report& report);

// Memory and latency over time: live_soak, live_soak_p95_ratio. The first third warms up.
void MeasureLiveSoak(double minutes, Report& report);

struct LiveBenchmarkOptions {
  // For which truth, arm, fusion, order and trace begin new scenes, and the length of the soak;
  // empty: 3, 3, 4, 4, 4 and 30.
  std::optional<double> minutes = {};
  std::string samples = {};  // as in SceneOptions
};

// The parts by the names by which they can be measured alone.
std::vector<std::pair<std::string, std::function<void(Report&)>>> LiveParts(
    const LiveBenchmarkOptions& options = {});
// All of them.
void MeasureLive(Report& report);

// The figure beside its limit, with the ratio to the yardstick of this run, if there is one, in its
// text; `asked_ratio` is the ratio that decides on machines of another speed.
Figure BesideYardstick(Figure figure, double limit, std::optional<double> asked_ratio,
                       Report& report);

}  // namespace cwm::benchmarks
