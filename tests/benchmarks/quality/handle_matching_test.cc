#include "tests/benchmarks/quality/handle_matching.h"

#include <gtest/gtest.h>

namespace cwm::benchmarks {
namespace {

// One mug: a body of 200 points and a handle of 100, labelled as an object of one shape and one
// handle.
class MugWithHandle : public ::testing::Test {
 protected:
  static constexpr int kBody = 200, kHandle = 100;

  MugWithHandle() {
    scene_.objects = {
        {.name = "mug",
         .parts = {{.shape = Sphere{0.1}}, {.shape = Sphere{0.02}}},
         .part_roles = {perception::PieceRole::kBody, perception::PieceRole::kHandle}}};
    scan_.cloud.points.assign(kBody + kHandle, Eigen::Vector3f::Zero());
    scan_.object.assign(kBody + kHandle, 0);
    scan_.part.assign(kBody, 0);
    scan_.part.insert(scan_.part.end(), kHandle, 1);
    auto model = std::make_shared<HybridModel>();
    model->shapes.resize(1);
    model->handles.resize(1);
    interpretation_.objects.resize(1);
    interpretation_.objects[0].model = model;
  }

  // The tally if the last `count` points are labelled as the handle.
  HandleTally TallyWithHandleOf(int count) {
    interpretation_.labels.assign(kBody + kHandle, 21);
    for (int k = 0; k < count; ++k) interpretation_.labels[kBody + kHandle - 1 - k] = 22;
    HandleTally tally;
    AddHandles("mug", {scene_, {}, scan_, interpretation_}, tally);
    return tally;
  }

  perception::SimulatedScene scene_;
  perception::SimulatedCloud scan_;
  perception::SceneInterpretation interpretation_;
};

TEST_F(MugWithHandle, IsFoundWithHalfOfItsPoints) {
  EXPECT_EQ(TallyWithHandleOf(50).found_count, 1);
  EXPECT_EQ(TallyWithHandleOf(50).right_count, 1);
  EXPECT_EQ(TallyWithHandleOf(49).found_count, 0);
  EXPECT_EQ(TallyWithHandleOf(49).precision(), 0);
  EXPECT_EQ(TallyWithHandleOf(200).found_count, 1);
  EXPECT_EQ(TallyWithHandleOf(201).found_count, 0);
}

TEST_F(MugWithHandle, IsMissedWhereNoneIsReported) {
  const HandleTally tally = TallyWithHandleOf(0);
  EXPECT_EQ(tally.true_count, 1);
  EXPECT_EQ(tally.recall(), 0);
  EXPECT_EQ(tally.reported_count, 0);
  EXPECT_EQ(tally.failures.size(), 1u);
}

TEST_F(MugWithHandle, OfTooFewPointsIsNotAskedFor) {
  for (int k = 0; k < 41; ++k) scan_.object[kBody + k] = -1;
  EXPECT_EQ(TallyWithHandleOf(0).true_count, 0);
  EXPECT_EQ(TallyWithHandleOf(59).right_count, 1) << "but reporting it is right";
}

TEST_F(MugWithHandle, ASpoutIsNone) {
  scene_.objects[0].part_roles[1] = perception::PieceRole::kSpout;
  const HandleTally tally = TallyWithHandleOf(100);
  EXPECT_EQ(tally.true_count, 0);
  EXPECT_EQ(tally.precision(), 0);
}

}  // namespace
}  // namespace cwm::benchmarks
