// Streams of frames over a socket: answers, order, refusals, and what ends a stream. This file is
// longer than 500 lines: all of it is said to one stream of one camera.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "server/core/live/robot_states.h"
#include "server/wire/times.h"
#include "tests/server/rpc/depth_stream.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

constexpr double kStart_s = 1'700'000'000;

std::chrono::system_clock::time_point StampAt(double stamp_s) {
  return std::chrono::system_clock::time_point(
      std::chrono::microseconds(std::llround(1e6 * stamp_s)));
}

// A hand that goes up and down.
v1::LoadRobotHeader Lift() {
  v1::LoadRobotHeader header;
  header.set_urdf(
      "<robot name='arm'><link name='base'/><link name='hand'/>"
      "<joint name='lift' type='prismatic'><parent link='base'/><child link='hand'/>"
      "<axis xyz='0 0 1'/><limit lower='0' upper='1' velocity='1' effort='1'/></joint></robot>");
  return header;
}

class StreamCloudsTest : public RunningServer {
 protected:
  // The status of a stream that sends this calibration.
  grpc::Status StatusOf(const v1::SensorCalibration& calibration) {
    DepthStream stream(*perception_);
    stream.Send(calibration);
    return stream.Finish();
  }
  void ExpectInvalid(const v1::SensorCalibration& calibration, const std::string& field) {
    const grpc::Status status = StatusOf(calibration);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << status.error_message();
    EXPECT_EQ(FieldIn(status), field) << status.error_message();
  }
  // The answer to a frame that is refused; the stream goes on.
  void ExpectRefused(const v1::SensorFrame& frame, const std::string& reason,
                     const std::string& text) {
    ASSERT_TRUE(stream_.Send(frame));
    const auto answer = stream_.Next();
    ASSERT_TRUE(answer.has_value());
    EXPECT_EQ(answer->fate(), v1::FRAME_FATE_REFUSED);
    EXPECT_EQ(answer->reason(), reason) << answer->message();
    EXPECT_THAT(answer->message(), HasSubstr(text));
    EXPECT_EQ(answer->frame(), next_frame_);
    ++next_frame_;
  }
  v1::StreamCloudsResponse MustProcess(const v1::SensorFrame& frame) {
    ++next_frame_;
    return stream_.MustProcess(frame);
  }
  v1::ListSensorsResponse Sensors() {
    Call call;
    v1::ListSensorsResponse response;
    EXPECT_TRUE(perception_->ListSensors(&call, {}, &response).ok());
    return response;
  }
  grpc::Status SetPose(const v1::SetSensorPoseRequest& request) {
    Call call;
    v1::SetSensorPoseResponse response;
    return perception_->SetSensorPose(&call, request, &response);
  }

  const v1::SensorCalibration camera_ = SmallCamera();
  DepthStream stream_{*perception_};
  std::int64_t next_frame_ = 0;
};

TEST_F(StreamCloudsTest, EachFrameIsAnsweredOnceWithTheTimeThatItTook) {
  ASSERT_TRUE(stream_.Send(camera_));
  for (int k = 0; k < 5; ++k) {
    const v1::SensorFrame frame = WallFrame(camera_, 1.5F, kStart_s + k);
    const auto begin = std::chrono::steady_clock::now();
    const v1::StreamCloudsResponse answer = MustProcess(frame);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
    EXPECT_EQ(answer.frame(), k);
    EXPECT_EQ(answer.frame_stamp().seconds(), frame.frame_stamp().seconds());
    EXPECT_FALSE(answer.world_uid().empty());
    EXPECT_EQ(answer.x_world_sensor().tz_m(), 1);
    const v1::PixelCounts& pixels = answer.pixels();
    EXPECT_EQ(pixels.consistent() + pixels.nearer() + pixels.farther() + pixels.missing(), 64 * 48);
    double sum_ms = 0;
    for (const v1::StageTime& stage : answer.stages()) sum_ms += stage.elapsed_ms();
    EXPECT_GT(sum_ms, 0);
    EXPECT_LT(sum_ms, took.count());
  }
  EXPECT_TRUE(stream_.Finish().ok());
}

TEST_F(StreamCloudsTest, ADepthOfAnyFormIsTheSame) {
  v1::SensorCalibration camera = camera_;
  camera.mutable_depth()->set_type(v1::DEPTH_TYPE_U16);
  camera.mutable_depth()->set_unit_m(0.0005);
  v1::SensorFrame frame = WallFrame(camera_, 1.5F, kStart_s);
  std::vector<std::uint16_t> depths(std::size_t{64} * 48, 3000);
  depths[0] = 0;
  depths[1] = std::numeric_limits<std::uint16_t>::max();
  frame.set_depth(reinterpret_cast<const char*>(depths.data()), 2 * depths.size());
  ASSERT_TRUE(stream_.Send(camera));
  const v1::StreamCloudsResponse answer = MustProcess(frame);
  EXPECT_EQ(answer.pixels().missing(), 2);
}

TEST_F(StreamCloudsTest, PointsTellTheirCamera) {
  v1::SensorCalibration points = camera_;
  points.clear_depth();
  v1::IngestCloudHeader described;
  DescribePoints(1, &described);
  *points.mutable_layout() = described.layout();
  points.set_width(64);
  points.set_height(48);
  std::vector<float> xyz;
  for (int v = 0; v < 48; ++v) {
    for (int u = 0; u < 64; ++u) {
      const bool is_missing = u == 3 && v == 4;
      const float z = is_missing ? std::numeric_limits<float>::quiet_NaN() : 1.5F;
      xyz.insert(xyz.end(), {z * (u - 31.5F) / 64, z * (v - 23.5F) / 64, z});
    }
  }
  v1::SensorFrame frame = WallFrame(camera_, 1.5F, kStart_s);
  frame.set_points(reinterpret_cast<const char*>(xyz.data()), 4 * xyz.size());
  ASSERT_TRUE(stream_.Send(points));
  const v1::StreamCloudsResponse answer = MustProcess(frame);
  EXPECT_EQ(answer.pixels().missing(), 1);
  // The wrong member of the two.
  frame = WallFrame(camera_, 1.5F, kStart_s + 1);
  ExpectRefused(frame, "INVALID_FIELD", "frame.points: is absent");
}

TEST_F(StreamCloudsTest, TheNewestFrameWinsAndAnswersStayInOrder) {
  // Large frames, so that many come while one is processed.
  const v1::SensorCalibration camera = SmallCamera("head", 640, 480);
  ASSERT_TRUE(stream_.Send(camera));
  constexpr int kFrames = 60;
  std::thread sender([&] {
    for (int k = 0; k < kFrames; ++k) {
      stream_.Send(WallFrame(camera, 1.5F, kStart_s + 0.001 * k));
    }
    stream_.WritesDone();
  });
  int processed = 0;
  int dropped = 0;
  std::optional<v1::StreamCloudsResponse> last;
  for (int k = 0; const auto answer = stream_.Next(); ++k) {
    EXPECT_EQ(answer->frame(), k);
    processed += answer->fate() == v1::FRAME_FATE_PROCESSED ? 1 : 0;
    dropped += answer->fate() == v1::FRAME_FATE_DROPPED ? 1 : 0;
    last = answer;
  }
  sender.join();
  EXPECT_EQ(processed + dropped, kFrames);
  EXPECT_GT(processed, 0);
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->fate(), v1::FRAME_FATE_PROCESSED);  // the newest is never dropped
  EXPECT_TRUE(stream_.Finish().ok());
  const v1::ListSensorsResponse sensors = Sensors();
  ASSERT_EQ(sensors.sensors_size(), 1);
  EXPECT_EQ(sensors.sensors(0).processed_count(), processed);
  EXPECT_EQ(sensors.sensors(0).dropped_count(), dropped);
}

TEST_F(StreamCloudsTest, AnOlderFrameIsRefusedAlsoAfterTheSensorReconnects) {
  ASSERT_TRUE(stream_.Send(camera_));
  MustProcess(WallFrame(camera_, 1.5F, kStart_s + 10));
  ExpectRefused(WallFrame(camera_, 1.5F, kStart_s + 9), "STALE_FRAME", "1000 ms older");
  ExpectRefused(WallFrame(camera_, 1.5F, kStart_s + 10), "STALE_FRAME", "must be newer");
  MustProcess(WallFrame(camera_, 1.5F, kStart_s + 11));
  DepthStream again(*perception_);
  ASSERT_TRUE(again.Send(camera_));
  ASSERT_TRUE(again.Send(WallFrame(camera_, 1.5F, kStart_s + 11)));
  const auto answer = again.Next();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->reason(), "STALE_FRAME");
  EXPECT_EQ(again.MustProcess(WallFrame(camera_, 1.5F, kStart_s + 12)).frame(), 1);
}

TEST_F(StreamCloudsTest, AFrameThatIsNotValidIsRefusedAndTheStreamGoesOn) {
  ASSERT_TRUE(stream_.Send(camera_));
  v1::SensorFrame frame = WallFrame(camera_, 1.5F, kStart_s);
  frame.mutable_depth()->pop_back();
  ExpectRefused(frame, "INVALID_FIELD", "frame.depth: has 12287 bytes, must have 12288");
  frame.clear_image();
  ExpectRefused(frame, "INVALID_FIELD", "frame.depth: is absent");
  frame = WallFrame(camera_, 1.5F, kStart_s);
  frame.mutable_x_world_sensor()->set_qw(0.5);
  ExpectRefused(frame, "INVALID_FIELD", "frame.x_world_sensor");
  frame = WallFrame(camera_, 1.5F, kStart_s);
  frame.add_pose_covariance(1);
  ExpectRefused(frame, "INVALID_FIELD", "frame.pose_covariance: holds 1 numbers");
  frame = WallFrame(camera_, 1.5F, kStart_s);
  frame.mutable_frame_stamp()->set_nanos(-1);
  ExpectRefused(frame, "INVALID_FIELD", "frame.frame_stamp");
  const double now_s =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  ExpectRefused(WallFrame(camera_, 1.5F, now_s + 60), "INVALID_FIELD", "ahead of the server's");
  frame = WallFrame(camera_, 1.5F, kStart_s);
  frame.mutable_exposure()->set_seconds(-1);
  ExpectRefused(frame, "INVALID_FIELD", "frame.exposure");
  MustProcess(WallFrame(camera_, 1.5F, kStart_s));  // of years ago, but its first
  EXPECT_TRUE(stream_.Finish().ok());
  EXPECT_EQ(Sensors().sensors(0).refused_count(), 7);
}

TEST_F(StreamCloudsTest, DepthsThatAreNoNumbersAreNoReturns) {
  ASSERT_TRUE(stream_.Send(camera_));
  for (const float depth_m :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
        -std::numeric_limits<float>::infinity(), -1.0F, 0.0F, 1e30F}) {
    const v1::StreamCloudsResponse answer =
        MustProcess(WallFrame(camera_, depth_m, kStart_s + next_frame_));
    EXPECT_EQ(answer.pixels().missing(), 64 * 48) << depth_m;
    EXPECT_EQ(answer.reason(), "NO_RETURN");
  }
}

TEST_F(StreamCloudsTest, ACalibrationThatIsNotValidIsRefusedByItsField) {
  v1::SensorCalibration bad = camera_;
  bad.mutable_depth()->mutable_pinhole()->set_fx_px(0);
  ExpectInvalid(bad, "calibration.depth.pinhole.fx_px");
  bad = camera_;
  bad.mutable_depth()->mutable_pinhole()->set_fy_px(std::numeric_limits<double>::quiet_NaN());
  ExpectInvalid(bad, "calibration.depth.pinhole.fy_px");
  bad = camera_;
  bad.mutable_depth()->mutable_pinhole()->set_cx_px(5'000);
  ExpectInvalid(bad, "calibration.depth.pinhole.cx_px");
  bad = camera_;
  bad.mutable_depth()->mutable_pinhole()->set_cy_px(-5'000);
  ExpectInvalid(bad, "calibration.depth.pinhole.cy_px");
  bad = camera_;
  bad.mutable_depth()->set_width(0);
  ExpectInvalid(bad, "calibration.depth.width");
  bad = camera_;
  bad.mutable_depth()->set_type(v1::DEPTH_TYPE_UNSPECIFIED);
  ExpectInvalid(bad, "calibration.depth.type");
  bad = camera_;
  bad.mutable_depth()->set_unit_m(-1);
  ExpectInvalid(bad, "calibration.depth.unit_m");
  bad = camera_;
  bad.clear_depth();
  ExpectInvalid(bad, "calibration.depth");
  bad = camera_;
  bad.clear_sensor();
  ExpectInvalid(bad, "calibration.sensor");
  bad = camera_;
  bad.mutable_mount()->set_robot("arm");
  ExpectInvalid(bad, "calibration.mount");
  bad = camera_;
  bad.set_least_range_m(3);
  bad.set_greatest_range_m(2);
  ExpectInvalid(bad, "calibration.greatest_range_m");
  bad = camera_;
  bad.set_pose_sigma_m(-1);
  ExpectInvalid(bad, "calibration.pose_sigma_m");
  bad = camera_;
  bad.mutable_depth()->set_width(8'000);
  bad.mutable_depth()->set_height(8'000);
  bad.mutable_depth()->mutable_pinhole()->set_fx_px(8'000);
  bad.mutable_depth()->mutable_pinhole()->set_fy_px(8'000);
  ExpectInvalid(bad, "calibration.depth");
}

TEST_F(StreamCloudsTest, MessagesOutOfOrderEndTheStream) {
  DepthStream no_calibration(*perception_);
  no_calibration.Send(WallFrame(camera_, 1.5F, kStart_s));
  EXPECT_EQ(FieldIn(no_calibration.Finish()), "frame");
  DepthStream twice(*perception_);
  twice.Send(camera_);
  twice.Send(camera_);
  EXPECT_EQ(FieldIn(twice.Finish()), "calibration");
  DepthStream empty(*perception_);
  EXPECT_EQ(FieldIn(empty.Finish()), "calibration");
  DepthStream nothing(*perception_);
  nothing.Send(camera_);
  EXPECT_TRUE(nothing.Finish().ok());
}

TEST_F(StreamCloudsTest, APoseMayComeWithTheFrameOrFromTheWorld) {
  v1::SensorCalibration nowhere = camera_;
  nowhere.clear_x_world_sensor();
  ASSERT_TRUE(stream_.Send(nowhere));
  ExpectRefused(WallFrame(camera_, 1.5F, kStart_s), "SENSOR_POSE_UNKNOWN", "x_world_sensor");
  v1::SensorFrame frame = WallFrame(camera_, 1.5F, kStart_s);
  *frame.mutable_x_world_sensor() = camera_.x_world_sensor();
  frame.mutable_x_world_sensor()->set_tz_m(2);
  EXPECT_EQ(MustProcess(frame).x_world_sensor().tz_m(), 2);
  v1::SetSensorPoseRequest set;
  set.set_sensor("head");
  *set.mutable_x_world_sensor() = camera_.x_world_sensor();
  set.mutable_x_world_sensor()->set_tz_m(3);
  EXPECT_TRUE(SetPose(set).ok());
  EXPECT_EQ(MustProcess(WallFrame(camera_, 1.5F, kStart_s + 1)).x_world_sensor().tz_m(), 3);
}

TEST_F(StreamCloudsTest, PosesAreSetForKnownSensorsOnly) {
  PutBox("a", 0);
  v1::SetSensorPoseRequest set;
  set.set_sensor("head");
  *set.mutable_x_world_sensor() = camera_.x_world_sensor();
  EXPECT_EQ(ReasonIn(SetPose(set)), "SENSOR_UNKNOWN");
  ASSERT_TRUE(stream_.Send(camera_));
  MustProcess(WallFrame(camera_, 1.5F, kStart_s));
  set.set_use_estimate(true);
  EXPECT_EQ(ReasonIn(SetPose(set)), "NO_ESTIMATE");
  set.clear_pose();
  EXPECT_EQ(FieldIn(SetPose(set)), "pose");
}

TEST_F(StreamCloudsTest, ASecondStreamOfASensorTakesOver) {
  ASSERT_TRUE(stream_.Send(camera_));
  MustProcess(WallFrame(camera_, 1.5F, kStart_s));
  DepthStream second(*perception_);
  ASSERT_TRUE(second.Send(camera_));
  second.MustProcess(WallFrame(camera_, 1.5F, kStart_s + 1));
  EXPECT_EQ(stream_.Next(), std::nullopt);
  const grpc::Status status = stream_.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::ABORTED);
  EXPECT_EQ(ReasonIn(status), "SENSOR_TAKEN_OVER");
  second.MustProcess(WallFrame(camera_, 1.5F, kStart_s + 2));
  EXPECT_TRUE(second.Finish().ok());
}

TEST_F(StreamCloudsTest, AWorldDeletedMeanwhileEndsTheStream) {
  ASSERT_TRUE(stream_.Send(camera_));
  MustProcess(WallFrame(camera_, 1.5F, kStart_s));
  Call call;
  v1::DeleteWorldRequest request;
  request.set_world("default");
  v1::DeleteWorldResponse response;
  ASSERT_TRUE(world_->DeleteWorld(&call, request, &response).ok());
  EXPECT_EQ(stream_.Next(), std::nullopt);
  const grpc::Status status = stream_.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(ReasonIn(status), "WORLD_DELETED");
}

TEST_F(StreamCloudsTest, AMountNamesALinkOfARobotOfTheWorld) {
  v1::SensorCalibration camera = camera_;
  camera.clear_x_world_sensor();
  camera.mutable_mount()->set_robot("arm");
  camera.mutable_mount()->set_link("wrist");
  grpc::Status status = StatusOf(camera);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(ReasonIn(status), "ROBOT_UNKNOWN");
  LoadRobot("arm", Lift());
  status = StatusOf(camera);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(ReasonIn(status), "LINK_UNKNOWN");
  camera.mutable_mount()->set_link("hand");
  camera.mutable_mount()->mutable_x_link_sensor()->set_tz_m(0.25);
  camera.mutable_mount()->mutable_x_link_sensor()->set_qw(1);
  ASSERT_TRUE(stream_.Send(camera));
  // Nobody has told where the robot stands.
  ExpectRefused(WallFrame(camera_, 1.5F, kStart_s), "ROBOT_STATE_MISSING", "hand");
  Call setting;
  v1::ApplyChangesRequest set;
  v1::SetRobotState& state = *set.add_changes()->mutable_robot_state();
  state.set_name("arm");
  v1::VariableValue& lift = *state.mutable_joints()->add_values();
  lift.set_variable("lift");
  lift.set_value(0.5);
  v1::ApplyChangesResponse applied;
  ASSERT_TRUE(world_->ApplyChanges(&setting, set, &applied).ok());
  EXPECT_EQ(MustProcess(WallFrame(camera_, 1.5F, kStart_s)).x_world_sensor().tz_m(), 0.75);
  ASSERT_EQ(Sensors().sensors_size(), 1);
  EXPECT_EQ(Sensors().sensors(0).mount().link(), "hand");
  Call call;
  v1::DeleteRobotRequest request;
  request.set_name("arm");
  v1::DeleteRobotResponse response;
  ASSERT_TRUE(robot_->DeleteRobot(&call, request, &response).ok());
  ExpectRefused(WallFrame(camera_, 1.5F, kStart_s + 1), "ROBOT_STATE_MISSING", "arm/hand");
  EXPECT_TRUE(stream_.Finish().ok());
}

TEST_F(StreamCloudsTest, AFrameWaitsForTheStateOfItsRobot) {
  LoadRobot("arm", Lift());
  Call call;
  v1::StreamRobotStatesResponse response;
  const auto telling = robot_->StreamRobotStates(&call, &response);
  const auto tell = [&](double stamp_s, double lift_m) {
    v1::StreamRobotStatesRequest request;
    v1::RobotStateRows& states = *request.mutable_states();
    *states.add_stamps() = TimePointToProto(StampAt(stamp_s));
    states.mutable_rows()->set_scalar(v1::SCALAR_F64);
    states.mutable_rows()->mutable_data()->assign(reinterpret_cast<const char*>(&lift_m),
                                                  sizeof(lift_m));
    return telling->Write(request);
  };
  v1::StreamRobotStatesRequest first;
  first.mutable_header()->set_robot("arm");
  ASSERT_TRUE(telling->Write(first));
  v1::SensorCalibration camera = camera_;
  camera.clear_x_world_sensor();
  camera.mutable_mount()->set_robot("arm");
  camera.mutable_mount()->set_link("hand");
  ASSERT_TRUE(stream_.Send(camera));
  const auto world = *application_.worlds.Find("");
  // The state at the frame's stamp comes a little after the frame.
  int waited = 0;
  for (int k = 1; k <= 20; ++k) {
    const double stamp_s = kStart_s + 0.1 * k;
    ASSERT_TRUE(tell(stamp_s - 0.05, 0.25));
    while (world->robot_states().Awaits(StampAt(stamp_s - 0.05))) std::this_thread::yield();
    ASSERT_TRUE(stream_.Send(WallFrame(camera_, 1.5F, stamp_s)));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ASSERT_TRUE(tell(stamp_s + 0.01, 0.5));
    const auto answer = stream_.Next();
    ASSERT_TRUE(answer.has_value());
    waited += answer->fate() == v1::FRAME_FATE_PROCESSED ? 1 : 0;
    if (answer->fate() == v1::FRAME_FATE_PROCESSED) {
      EXPECT_NEAR(answer->x_world_sensor().tz_m(), 0.25 + 0.25 * 5 / 6, 1e-6);
    } else {
      EXPECT_EQ(answer->reason(), "ROBOT_STATE_STALE") << answer->message();
    }
  }
  EXPECT_GE(waited, 15) << "a busy machine may delay some states by more than 20 ms";
  // Not for long: no state comes any more.
  ASSERT_TRUE(stream_.Send(WallFrame(camera_, 1.5F, kStart_s + 2.1)));
  const auto answer = stream_.Next();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->reason(), "ROBOT_STATE_STALE") << answer->message();
  telling->WritesDone();
  EXPECT_TRUE(telling->Finish().ok());
  EXPECT_TRUE(stream_.Finish().ok());
}

TEST_F(StreamCloudsTest, SensorsAreListedWithTheirRateAndLatency) {
  ASSERT_TRUE(stream_.Send(camera_));
  for (int k = 0; k < 4; ++k) MustProcess(WallFrame(camera_, 1.5F, kStart_s + k));
  v1::ListSensorsResponse sensors = Sensors();
  ASSERT_EQ(sensors.sensors_size(), 1);
  const v1::Sensor& sensor = sensors.sensors(0);
  EXPECT_EQ(sensor.name(), "head");
  EXPECT_TRUE(sensor.is_streaming());
  EXPECT_EQ(sensor.processed_count(), 4);
  EXPECT_GT(sensor.latency_p50_ms(), 0);
  EXPECT_GE(sensor.latency_p95_ms(), sensor.latency_p50_ms());
  EXPECT_GT(sensor.frame_rate(), 0);
  EXPECT_EQ(sensor.last_frame().seconds(), static_cast<std::int64_t>(kStart_s) + 3);
  EXPECT_EQ(sensor.x_world_sensor().tz_m(), 1);
  EXPECT_GT(sensor.delay_ms(), 0);
  EXPECT_TRUE(stream_.Finish().ok());
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (Sensors().sensors(0).is_streaming() && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_FALSE(Sensors().sensors(0).is_streaming());
}

TEST_F(StreamCloudsTest, WatchersOfFramesGetTheNewestPointsWithTheirClasses) {
  ASSERT_TRUE(stream_.Send(camera_));
  MustProcess(WallFrame(camera_, 1.5F, kStart_s));
  Call call;
  v1::WatchFramesRequest request;
  request.set_max_points(100);
  request.set_max_rate_hz(50);
  const auto watch = perception_->WatchFrames(&call, request);
  v1::WatchFramesResponse frame;
  ASSERT_TRUE(watch->Read(&frame));
  EXPECT_EQ(frame.sensor(), "head");
  EXPECT_EQ(frame.frame_stamp().seconds(), static_cast<std::int64_t>(kStart_s));
  EXPECT_LE(frame.classes().size(), 100U);
  EXPECT_GT(frame.classes().size(), 25U);
  ASSERT_EQ(frame.points().size(), 12 * frame.classes().size());
  const float* points = reinterpret_cast<const float*>(frame.points().data());
  for (std::size_t i = 0; i < frame.classes().size(); ++i) {
    EXPECT_NEAR(points[3 * i], 1.5, 1e-6);  // the wall is before the camera, along x
  }
  MustProcess(WallFrame(camera_, 1.5F, kStart_s + 1));
  ASSERT_TRUE(watch->Read(&frame));
  EXPECT_EQ(frame.frame_stamp().seconds(), static_cast<std::int64_t>(kStart_s) + 1);
  call.TryCancel();
  EXPECT_FALSE(watch->Read(&frame));
  watch->Finish();
  Call wrong;
  request.set_max_rate_hz(-1);
  EXPECT_EQ(FieldIn(perception_->WatchFrames(&wrong, request)->Finish()), "max_rate_hz");
}

TEST_F(StreamCloudsTest, AStreamThatIsCancelledLeavesTheServerServing) {
  for (int k = 0; k < 20; ++k) {
    Call call;
    const auto stream = perception_->StreamClouds(&call);
    v1::StreamCloudsRequest request;
    *request.mutable_calibration() = camera_;
    stream->Write(request);
    *request.mutable_frame() = WallFrame(camera_, 1.5F, kStart_s + k);
    stream->Write(request);
    call.TryCancel();
    stream->Finish();
  }
  ASSERT_TRUE(stream_.Send(camera_));
  MustProcess(WallFrame(camera_, 1.5F, kStart_s + 100));
}

}  // namespace
}  // namespace cwm::server
