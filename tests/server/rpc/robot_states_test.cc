// Streams of robots' states over a real socket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "server/core/live/robot_states.h"
#include "server/wire/times.h"
#include "tests/collision/world/test_arm.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using collision::testing::ArmSrdf;
using collision::testing::ArmUrdf;
using std::chrono::milliseconds;
using SystemTime = std::chrono::system_clock::time_point;
using Telling = grpc::ClientWriter<v1::StreamRobotStatesRequest>;

SystemTime Now() { return std::chrono::system_clock::now(); }

v1::StreamRobotStatesRequest HeaderFor(const std::string& robot,
                                       const std::vector<std::string>& variables) {
  v1::StreamRobotStatesRequest request;
  request.mutable_header()->set_robot(robot);
  for (const std::string& variable : variables) request.mutable_header()->add_variables(variable);
  return request;
}

// Rows of doubles, one for each stamp.
v1::StreamRobotStatesRequest StatesAt(const std::vector<SystemTime>& stamps,
                                      const std::vector<double>& values) {
  v1::StreamRobotStatesRequest request;
  for (const SystemTime stamp : stamps) {
    *request.mutable_states()->add_stamps() = TimePointToProto(stamp);
  }
  v1::JointRows* rows = request.mutable_states()->mutable_rows();
  rows->set_scalar(v1::SCALAR_F64);
  for (const double value : values) {
    rows->mutable_data()->append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  return request;
}

class StreamRobotStatesTest : public RunningServer {
 protected:
  StreamRobotStatesTest() {
    v1::LoadRobotHeader header;
    header.set_urdf(ArmUrdf());
    header.set_srdf(ArmSrdf());
    LoadRobot("arm", header);
  }

  std::unique_ptr<Telling> Begin(const std::vector<std::string>& variables = {"elbow"},
                                 const std::string& robot = "arm") {
    auto telling = robot_->StreamRobotStates(&call_, &response_);
    EXPECT_TRUE(telling->Write(HeaderFor(robot, variables)));
    return telling;
  }
  // The end of a stream that has only this message after its header.
  grpc::Status Refusal(const v1::StreamRobotStatesRequest& message,
                       const std::vector<std::string>& variables = {"elbow"}) {
    Call call;
    v1::StreamRobotStatesResponse response;
    const auto telling = robot_->StreamRobotStates(&call, &response);
    telling->Write(HeaderFor("arm", variables));
    telling->Write(message);
    telling->WritesDone();
    return telling->Finish();
  }
  void DeleteRobot(const std::string& name) {
    Call call;
    v1::DeleteRobotRequest request;
    request.set_name(name);
    v1::DeleteRobotResponse response;
    ASSERT_TRUE(robot_->DeleteRobot(&call, request, &response).ok());
  }
  std::shared_ptr<World> Served() { return *application_.worlds.Find(""); }
  double Elbow() { return Served()->Snapshot()->FindRobot("arm")->state[0]; }
  // Waits until the world's elbow is there.
  bool ReachesElbow(double value) {
    for (int i = 0; i < 2'000 && Elbow() != value; ++i) {
      std::this_thread::sleep_for(milliseconds(5));
    }
    return Elbow() == value;
  }

  Call call_;
  v1::StreamRobotStatesResponse response_;
};

TEST_F(StreamRobotStatesTest, TheNewestStateBecomesTheRobotsAndTheStreamEndsWithASummary) {
  const std::int64_t before = Served()->Snapshot()->revision().value;
  const auto telling = Begin();
  const SystemTime now = Now();
  ASSERT_TRUE(
      telling->Write(StatesAt({now - milliseconds(20), now - milliseconds(10)}, {0.1, 0.2})));
  EXPECT_TRUE(ReachesElbow(0.2)) << "before the stream ends";
  ASSERT_TRUE(telling->Write(
      StatesAt({now, now - milliseconds(10), now - milliseconds(15)}, {0.4, 9, 0.15})));
  telling->WritesDone();
  const grpc::Status status = telling->Finish();
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response_.state_count(), 4);
  EXPECT_EQ(response_.ignored_count(), 1) << "the stamp that was known";
  EXPECT_EQ(response_.world_uid(), Served()->uid());
  EXPECT_EQ(Elbow(), 0.4);
  EXPECT_LE(response_.revision(), Served()->Snapshot()->revision().value);
  EXPECT_LE(Served()->Snapshot()->revision().value - before, 3);
  const auto robot = Served()->Snapshot()->FindRobot("arm");
  const RobotStateAt at = Served()->robot_states().StateAt(*robot, now - milliseconds(5));
  EXPECT_NEAR(at.values.at(0), 0.3, 1e-12);
  EXPECT_NEAR(at.speeds_per_s.at(0), 20, 1e-6);
}

TEST_F(StreamRobotStatesTest, AThousandStatesASecondMakeThirtyRevisions) {
  const std::int64_t before = Served()->Snapshot()->revision().value;
  const auto telling = Begin();
  const auto begin = std::chrono::steady_clock::now();
  int count = 0;
  while (std::chrono::steady_clock::now() - begin < milliseconds(500)) {
    ASSERT_TRUE(telling->Write(StatesAt({Now()}, {1e-4 * ++count})));
    std::this_thread::sleep_for(milliseconds(1));
  }
  telling->WritesDone();
  ASSERT_TRUE(telling->Finish().ok());
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
  const double revisions = static_cast<double>(response_.revision() - before);
  EXPECT_GE(revisions, 2);
  EXPECT_LE(revisions, passed.count() / 0.033 + 2);
  EXPECT_EQ(Elbow(), 1e-4 * count);
}

// The state may be in a write of its own or in that of another stream when the stream ends.
TEST_F(StreamRobotStatesTest, TheAnswerComesWhenTheLastStateIsTheRobots) {
  for (int k = 1; k <= 300; ++k) {
    Call call, call_beside;
    v1::StreamRobotStatesResponse response, response_beside;
    const auto telling = robot_->StreamRobotStates(&call, &response);
    const auto beside = robot_->StreamRobotStates(&call_beside, &response_beside);
    ASSERT_TRUE(telling->Write(HeaderFor("arm", {"elbow"})));
    ASSERT_TRUE(beside->Write(HeaderFor("arm", {"elbow"})));
    ASSERT_TRUE(telling->Write(StatesAt({Now()}, {1e-3 * k})));
    telling->WritesDone();
    beside->WritesDone();
    ASSERT_TRUE(telling->Finish().ok());
    ASSERT_EQ(Elbow(), 1e-3 * k);
    ASSERT_LE(response.revision(), Served()->Snapshot()->revision().value);
    ASSERT_TRUE(beside->Finish().ok());
  }
}

TEST_F(StreamRobotStatesTest, AllVariablesAndTheBaseMayBeTold) {
  const auto telling = Begin({});
  const SystemTime now = Now();
  v1::StreamRobotStatesRequest states = StatesAt({now}, {0.5, 0.1, 0.02, 1, 2, 3, 0, 0, 0, 1});
  states.mutable_states()->mutable_rows()->set_width(10);
  v1::PoseRows* bases = states.mutable_states()->mutable_x_world_base();
  const std::vector<double> base = {4, 5, 6, 0, 0, 0, 1};
  bases->set_scalar(v1::SCALAR_F64);
  bases->mutable_data()->assign(reinterpret_cast<const char*>(base.data()),
                                base.size() * sizeof(double));
  ASSERT_TRUE(telling->Write(states));
  telling->WritesDone();
  const grpc::Status status = telling->Finish();
  ASSERT_TRUE(status.ok()) << status.error_message();
  const auto robot = Served()->Snapshot()->FindRobot("arm");
  EXPECT_EQ(robot->state, (std::vector<double>{0.5, 0.1, 0.02, 1, 2, 3, 0, 0, 0, 1}));
  EXPECT_EQ(robot->X_WB.translation(), Vector3(4, 5, 6));
}

TEST_F(StreamRobotStatesTest, EndsWhenItsRobotIsDeletedOrReplaced) {
  const auto telling = Begin();
  ASSERT_TRUE(telling->Write(StatesAt({Now()}, {0.1})));
  ASSERT_TRUE(ReachesElbow(0.1));
  DeleteRobot("arm");
  grpc::Status status = telling->Finish();  // though the client ended nothing
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(ReasonIn(status), "ROBOT_UNKNOWN");

  v1::LoadRobotHeader header;
  header.set_urdf(ArmUrdf());
  LoadRobot("arm", header);
  Call call;
  const auto other = robot_->StreamRobotStates(&call, &response_);
  ASSERT_TRUE(other->Write(HeaderFor("arm", {"elbow"})));
  ASSERT_TRUE(other->Write(StatesAt({Now()}, {0.3})));
  ASSERT_TRUE(ReachesElbow(0.3));
  header.set_urdf(ArmUrdf("arm", "0.2"));
  LoadRobot("arm", header);
  status = other->Finish();
  EXPECT_EQ(ReasonIn(status), "ROBOT_UNKNOWN");
  EXPECT_THAT(status.error_message(), ::testing::HasSubstr("was replaced by another one"));
}

TEST_F(StreamRobotStatesTest, EndsWhenItsWorldIsDeletedAndWhenTheServerStops) {
  const auto telling = Begin();
  ASSERT_TRUE(telling->Write(StatesAt({Now()}, {0.1})));
  ASSERT_TRUE(ReachesElbow(0.1));
  Call call;
  v1::DeleteWorldRequest request;
  request.set_world("default");
  v1::DeleteWorldResponse response;
  ASSERT_TRUE(world_->DeleteWorld(&call, request, &response).ok());
  grpc::Status status = telling->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(ReasonIn(status), "WORLD_DELETED");

  v1::LoadRobotHeader header;
  header.set_urdf(ArmUrdf());
  LoadRobot("arm", header);
  Call last;
  const auto open = robot_->StreamRobotStates(&last, &response_);
  ASSERT_TRUE(open->Write(HeaderFor("arm", {"elbow"})));
  ASSERT_TRUE(open->Write(StatesAt({Now()}, {0.6})));
  ASSERT_TRUE(ReachesElbow(0.6));
  server_.reset();
  status = open->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(StreamRobotStatesTest, RefusesByFieldWhatIsNoState) {
  const SystemTime now = Now();
  const auto field = [&](const v1::StreamRobotStatesRequest& message,
                         const std::vector<std::string>& variables = {"elbow"}) {
    const grpc::Status status = Refusal(message, variables);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << status.error_message();
    return FieldIn(status);
  };
  EXPECT_EQ(field(StatesAt({now, now + std::chrono::seconds(30)}, {0.1, 0.2})), "states.stamps[1]");
  EXPECT_EQ(field(StatesAt({now}, {0.1, 0.2})), "states.rows");
  EXPECT_EQ(field(StatesAt({now}, {})), "states.rows.data");
  EXPECT_EQ(field(StatesAt({now}, {NAN})), "states.rows.data row 0");
  v1::StreamRobotStatesRequest wide = StatesAt({now}, {0.1, 0.2});
  wide.mutable_states()->mutable_rows()->set_width(2);
  EXPECT_EQ(field(wide), "states.rows.width");
  EXPECT_EQ(field(StatesAt({now}, {0.1}), {"elbow", "wheel"}), "header.variables[1]");
  EXPECT_EQ(field(StatesAt({now}, {0.1}), {"elbow", "elbow"}), "header.variables[1]");
  EXPECT_EQ(field(StatesAt({now}, {0.1}), {"elbow", "float/trans_x"}), "header.variables[1]");
  EXPECT_EQ(field(HeaderFor("arm", {})), "header");
  EXPECT_EQ(field({}), "what");
  EXPECT_EQ(Served()->Snapshot()->FindRobot("arm")->state[0], 0) << "nothing was taken";

  Call call;
  const auto headless = robot_->StreamRobotStates(&call, &response_);
  headless->Write(StatesAt({now}, {0.1}));
  headless->WritesDone();
  EXPECT_EQ(FieldIn(headless->Finish()), "states");
  const auto unknown = Begin({}, "leg");
  const grpc::Status status = unknown->Finish();
  EXPECT_EQ(ReasonIn(status), "ROBOT_UNKNOWN");
  EXPECT_THAT(status.error_message(),
              ::testing::StartsWith("header.robot: there is no robot \"leg\""));
}

TEST_F(StreamRobotStatesTest, WhatACancelledStreamToldLastIsPublished) {
  const auto telling = Begin();
  ASSERT_TRUE(telling->Write(StatesAt({Now()}, {0.1})));
  ASSERT_TRUE(ReachesElbow(0.1));
  ASSERT_TRUE(telling->Write(StatesAt({Now()}, {0.7})));
  RobotStates& states = Served()->robot_states();
  for (int i = 0; i < 400 && !states.DueAt().has_value() && Elbow() != 0.7; ++i) {
    std::this_thread::sleep_for(milliseconds(1));
  }
  call_.TryCancel();
  telling->Finish();
  EXPECT_TRUE(ReachesElbow(0.7));
}

}  // namespace
}  // namespace cwm::server
