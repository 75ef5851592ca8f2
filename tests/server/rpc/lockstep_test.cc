// Frames of several sensors in lockstep: their numbers, their answers, and how they end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/rpc/depth_stream.h"

namespace cwm::server {
namespace {

constexpr double kStart_s = 1'700'000'000;
constexpr int kFrames = 40;
constexpr float kWall_m = 1.5F, kBlock_m = 1.2F;
constexpr std::array<const char*, 2> kSensors = {"left", "right"};

struct TracedFrame {
  std::size_t sensor = 0;
  int frame = 0;
};
using Trace = std::map<std::int64_t, TracedFrame>;  // by sequence number

class LockstepStreamsTest : public RunningServer {
 protected:
  static v1::SensorCalibration CalibrationOf(std::size_t sensor, const std::string& world) {
    v1::SensorCalibration calibration = SmallCamera(kSensors[sensor]);
    calibration.set_world(world);
    calibration.set_lockstep(true);
    return calibration;
  }

  // A wall, before which a block comes, rests and goes.
  static v1::SensorFrame FrameOf(std::size_t sensor, int k) {
    v1::SensorFrame frame = WallFrame(SmallCamera(), kWall_m, kStart_s + k / 30.0);
    if (k < 5 || k > 30) return frame;
    constexpr std::size_t kWidth_px = 64, kEdge_px = 16;
    const std::size_t begin_px = k < 15 ? 2 * static_cast<std::size_t>(k) : 30;
    const std::vector<float> row(kEdge_px, kBlock_m + 0.01F * static_cast<float>(sensor));
    for (std::size_t v = kEdge_px; v < 2 * kEdge_px; ++v) {
      frame.mutable_depth()->replace(
          sizeof(float) * (kWidth_px * v + begin_px), sizeof(float) * kEdge_px,
          reinterpret_cast<const char*>(row.data()), sizeof(float) * kEdge_px);
    }
    return frame;
  }

  // Both sensors stream at once.
  Trace Record(const std::string& world) {
    std::array<std::vector<v1::StreamCloudsResponse>, kSensors.size()> answers;
    std::vector<std::thread> clients;
    for (std::size_t s = 0; s < kSensors.size(); ++s) {
      clients.emplace_back([&, s] {
        DepthStream stream(*perception_);
        EXPECT_TRUE(stream.Send(CalibrationOf(s, world)));
        std::size_t sent = 0;
        for (int k = 0; k < kFrames; ++k) {
          // One frame in four comes twice, and one before the last one is answered.
          const int times = k % 4 == 1 ? 2 : 1;
          for (int i = 0; i < times; ++i, ++sent) EXPECT_TRUE(stream.Send(FrameOf(s, k)));
          while (k % 4 != 2 && answers[s].size() < sent) {
            auto answer = stream.Next();
            ASSERT_TRUE(answer.has_value());
            answers[s].push_back(*std::move(answer));
          }
        }
        stream.WritesDone();
        while (auto answer = stream.Next()) answers[s].push_back(*std::move(answer));
        EXPECT_TRUE(stream.Finish().ok());
      });
    }
    for (std::thread& client : clients) client.join();
    Trace trace;
    for (std::size_t s = 0; s < kSensors.size(); ++s) {
      std::int64_t last = 0;
      for (const v1::StreamCloudsResponse& answer : answers[s]) {
        EXPECT_FALSE(answer.interpreting());
        if (answer.fate() != v1::FRAME_FATE_PROCESSED) {
          EXPECT_EQ(answer.sequence_number(), 0);
          continue;
        }
        EXPECT_GT(answer.sequence_number(), last);
        last = answer.sequence_number();
        const double stamp_s = static_cast<double>(answer.frame_stamp().seconds()) +
                               1e-9 * answer.frame_stamp().nanos() - kStart_s;
        trace[last] = {.sensor = s, .frame = static_cast<int>(std::lround(30 * stamp_s))};
      }
    }
    return trace;
  }

  void Replay(const std::string& world, const Trace& trace) {
    std::vector<std::unique_ptr<DepthStream>> streams;
    for (std::size_t s = 0; s < kSensors.size(); ++s) {
      streams.push_back(std::make_unique<DepthStream>(*perception_));
      ASSERT_TRUE(streams.back()->Send(CalibrationOf(s, world)));
    }
    for (const auto& [number, traced] : trace) {
      const auto answer = streams[traced.sensor]->MustProcess(FrameOf(traced.sensor, traced.frame));
      EXPECT_EQ(answer.sequence_number(), number);
    }
  }

  // The objects and the revision, without what is drawn anew in each world.
  std::vector<std::string> BytesOf(const std::string& world) {
    Call call;
    v1::ListObjectsRequest request;
    request.set_world(world);
    request.set_view(v1::OBJECT_VIEW_FULL);
    v1::ListObjectsResponse response;
    EXPECT_TRUE(world_->ListObjects(&call, request, &response).ok());
    std::vector<std::string> bytes = {std::to_string(response.revision())};
    for (v1::Object object : response.objects()) {
      object.clear_uid();
      bytes.push_back(object.SerializeAsString());
    }
    return bytes;
  }
};

TEST_F(LockstepStreamsTest, FramesOfAllSensorsAreNumberedWithoutGaps) {
  const Trace trace = Record("recorded");
  ASSERT_GT(trace.size(), std::size_t{kFrames});
  EXPECT_EQ(trace.begin()->first, 1);
  EXPECT_EQ(trace.rbegin()->first, static_cast<std::int64_t>(trace.size()));
}

TEST_F(LockstepStreamsTest, ATraceReplaysToTheBit) {
  const Trace trace = Record("recorded");
  const std::vector<std::string> recorded = BytesOf("recorded");
  EXPECT_GT(recorded.size(), 1U);
  for (const char* world : {"replayed", "replayed_again"}) {
    Replay(world, trace);
    EXPECT_EQ(BytesOf(world), recorded);
  }
}

TEST_F(LockstepStreamsTest, ASensorThatIsGoneGivesItsTurnToTheOthers) {
  DepthStream other(*perception_);
  ASSERT_TRUE(other.Send(CalibrationOf(1, "")));
  for (int k = 0; k < 20; ++k) {
    Call call;
    const auto stream = perception_->StreamClouds(&call);
    v1::StreamCloudsRequest request;
    *request.mutable_calibration() = CalibrationOf(0, "");
    stream->Write(request);
    *request.mutable_frame() = FrameOf(0, k);
    stream->Write(request);
    call.TryCancel();
    stream->Finish();
    EXPECT_GT(other.MustProcess(FrameOf(1, k)).sequence_number(), k);
  }
  EXPECT_TRUE(other.Finish().ok());
}

TEST_F(LockstepStreamsTest, AServerThatStopsEndsStreamsThatWait) {
  std::atomic<int> streaming = 0;
  std::vector<std::thread> clients;
  for (std::size_t s = 0; s < kSensors.size(); ++s) {
    clients.emplace_back([&, s] {
      DepthStream stream(*perception_);
      stream.Send(CalibrationOf(s, ""));
      bool is_open = true;
      for (int k = 0; is_open; ++k) {
        is_open = stream.Send(FrameOf(s, k)) && (k % 2 == 0 || stream.Next().has_value());
        if (k == 3) ++streaming;
      }
      EXPECT_EQ(stream.Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
    });
  }
  while (streaming < static_cast<int>(kSensors.size())) std::this_thread::yield();
  server_->Stop(std::chrono::minutes(1));
  for (std::thread& client : clients) client.join();
}

}  // namespace
}  // namespace cwm::server
