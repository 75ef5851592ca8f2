// The Franka Panda as MotionBenchMaker distributes it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <set>

#include "collision/robot/kinematics.h"
#include "collision/robot/robot_model.h"
#include "collision/robot/sphere_model.h"
#include "collision/robot/srdf.h"
#include "tests/collision/robot/panda_files.h"

namespace cwm::collision {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::PandaFiles;
using testing::ReadPandaFiles;

class Panda : public ::testing::Test {
 protected:
  void SetUp() override {
    files_ = ReadPandaFiles();
    if (!files_) GTEST_SKIP() << "the Panda (motion_bench_maker) is not in CWM_DATA";
    auto robot = ReadUrdf(files_->urdf, files_->meshes);
    ASSERT_TRUE(robot.ok()) << robot.status();
    robot_ = *std::move(robot);
    auto semantic = ReadSrdf(files_->srdf, robot_);
    ASSERT_TRUE(semantic.ok()) << semantic.status();
    semantic_ = *std::move(semantic);
    auto model = MakeRobotModel(robot_, &semantic_);
    ASSERT_TRUE(model.ok()) << model.status();
    model_ = *std::move(model);
  }

  std::optional<PandaFiles> files_;
  RobotDescription robot_;
  SemanticDescription semantic_;
  std::shared_ptr<const RobotModel> model_;
};

TEST_F(Panda, HasElevenLinksWithAMeshAndOfThoseLinkSixIsOpen) {
  EXPECT_EQ(robot_.links.size(), 13u);
  std::vector<std::string> open;
  int meshes = 0;
  for (const Link& link : robot_.links) {
    for (const CollisionGeometry& geometry : link.collisions) {
      const Mesh& mesh = std::get<Mesh>(geometry.shape);
      ++meshes;
      if (!mesh.watertight) open.push_back(link.name);
      Eigen::AlignedBox3d bounds;
      for (const Vector3& p : mesh.mesh->vertices) bounds.extend(p);
      EXPECT_GT(bounds.diagonal().norm(), 0.05) << link.name;  // metres, not millimetres
      EXPECT_LT(bounds.diagonal().norm(), 0.5) << link.name;
    }
  }
  EXPECT_EQ(meshes, 11);
  EXPECT_THAT(open, ElementsAre("panda_link6"));
  const auto finger = [&](const char* name) {
    return std::get<Mesh>(model_->links[*model_->FindLink(name)].collisions[0].shape).mesh;
  };
  EXPECT_EQ(finger("panda_leftfinger"), finger("panda_rightfinger"));  // shared
}

TEST_F(Panda, ItsArmHasSevenJointsAndItsHandNone) {
  const JointGroup* arm = model_->FindGroup("panda_arm");
  ASSERT_NE(arm, nullptr);
  EXPECT_THAT(arm->joints,
              ElementsAre("panda_joint1", "panda_joint2", "panda_joint3", "panda_joint4",
                          "panda_joint5", "panda_joint6", "panda_joint7"));
  EXPECT_EQ(arm->moved_links.size(), 12u);
  ASSERT_EQ(arm->states.size(), 3u);
  EXPECT_EQ(arm->states[0].name, "ready");
  EXPECT_THAT(arm->states[0].values, ElementsAre(0, -0.785, 0, -2.356, 0, 1.571, 0.785));
  EXPECT_THAT(model_->FindGroup("hand")->variables, IsEmpty());
  EXPECT_EQ(model_->FindGroup("panda_arm_hand")->variables, arm->variables);
  EXPECT_EQ(model_->variables[3].lower, -3.1416);
  EXPECT_EQ(model_->variables[3].upper, 0.0873);
}

TEST_F(Panda, ChecksThePairsThatItsSrdfLeaves) {
  std::set<std::pair<std::string, std::string>> left_out;
  for (const NamedLinkPair& pair : semantic_.disabled_pairs) {
    left_out.insert(std::minmax(pair.link1, pair.link2));
  }
  std::set<std::pair<std::string, std::string>> expected;
  for (const Link& a : robot_.links) {
    for (const Link& b : robot_.links) {
      if (a.name < b.name && !a.collisions.empty() && !b.collisions.empty() &&
          left_out.count({a.name, b.name}) == 0) {
        expected.insert({a.name, b.name});
      }
    }
  }
  // Link 7, hand and fingers are one body; the SRDF also disables their pairs.
  std::set<std::pair<std::string, std::string>> actual;
  for (const LinkPair& pair : model_->self_pairs) {
    actual.insert(std::minmax(model_->links[pair.first].name, model_->links[pair.second].name));
    EXPECT_LT(model_->links[pair.first].urdf_index, model_->links[pair.second].urdf_index);
  }
  EXPECT_EQ(actual, expected);
  EXPECT_EQ(model_->self_pairs.size(), 21u);  // of 55
  EXPECT_EQ(actual.count({"panda_hand", "panda_link5"}), 1u);
  EXPECT_EQ(actual.count({"panda_hand", "panda_link0"}), 1u);
}

// cited: modified Denavit-Hartenberg parameters of the Panda from the Franka Control Interface
// documentation, "Robot and interface specifications": a, d, alpha of joints 1 to 7.
struct DhRow {
  double a_m, d_m, alpha_rad;
};
constexpr double kRight = 1.5707963267948966;
constexpr std::array<DhRow, 7> kDh = {{{0, 0.333, 0},
                                       {0, 0, -kRight},
                                       {0, 0.316, kRight},
                                       {0.0825, 0, kRight},
                                       {-0.0825, 0.384, -kRight},
                                       {0, 0, kRight},
                                       {0.088, 0, kRight}}};
constexpr double kFlange_m = 0.107;

// Craig's convention: Rx(alpha) Tx(a) Rz(theta) Tz(d), written out.
Eigen::Matrix4d DhTransform(const DhRow& row, double theta) {
  const double ct = std::cos(theta), st = std::sin(theta);
  const double ca = std::cos(row.alpha_rad), sa = std::sin(row.alpha_rad);
  Eigen::Matrix4d T;
  T << ct, -st, 0, row.a_m,                  //
      st * ca, ct * ca, -sa, -row.d_m * sa,  //
      st * sa, ct * sa, ca, row.d_m * ca,    //
      0, 0, 0, 1;
  return T;
}

TEST_F(Panda, StandsWhereTheParametersOfItsMakerPutIt) {
  // derived: the URDF gives right angles with twelve digits; seven of them act on an arm of a
  // metre.
  constexpr double kDigits_m = 7 * 1e-11;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> angle(-3, 3);
  std::vector<Pose> poses(model_->links.size());
  for (int round = 0; round < 100; ++round) {
    std::vector<double> q(7);
    for (double& value : q) value = angle(random);
    LinkPoses(*model_, Pose::Identity(), q, poses);
    Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
    for (int i = 0; i < 7; ++i) {
      T = T * DhTransform(kDh[i], q[i]);
      const Pose& X_WL = poses[*model_->FindLink("panda_link" + std::to_string(i + 1))];
      ASSERT_LT((X_WL.matrix() - T).cwiseAbs().maxCoeff(), kDigits_m) << "link " << i + 1;
    }
    T = T * DhTransform({0, kFlange_m, 0}, 0);
    const Pose& X_WF = poses[*model_->FindLink("panda_link8")];
    ASSERT_LT((X_WF.matrix() - T).cwiseAbs().maxCoeff(), kDigits_m);
  }
}

TEST_F(Panda, ReadyIsInsideItsLimitsAndZeroIsNot) {
  const NamedState& ready = model_->FindGroup("panda_arm")->states[0];
  EXPECT_EQ(OutOfLimits(*model_, ready.values), std::nullopt);
  std::vector<double> bent = ready.values;
  bent[3] = 0.1;  // the elbow cannot bend the other way
  EXPECT_EQ(OutOfLimits(*model_, bent), 3);
  EXPECT_EQ(model_->variables[3].name, "panda_joint4");
}

TEST_F(Panda, HasFiftyNineSpheresAsGiven) {
  const auto spherized = ReadUrdf(files_->spherized_urdf, files_->meshes);
  ASSERT_TRUE(spherized.ok()) << spherized.status();
  const auto spheres = SphereModelFromUrdf(*spherized, *model_);
  ASSERT_TRUE(spheres.ok()) << spheres.status();
  std::size_t count = 0;
  for (const auto& of_link : spheres->links) count += of_link.size();
  EXPECT_EQ(count, 59u);
  const std::vector<LinkSphere>& base = spheres->links[*model_->FindLink("panda_link0")];
  ASSERT_EQ(base.size(), 1u);
  EXPECT_EQ(base[0].radius_m, 0.08);
  EXPECT_EQ(base[0].center_L, Vector3(0, 0, 0.05));
}

TEST_F(Panda, AMissingMeshIsNamedWithItsLink) {
  const auto robot = ReadUrdf(files_->urdf, [&](std::string_view uri) {
    if (uri.ends_with("link3.obj")) {
      return absl::StatusOr<std::string>(
          absl::NotFoundError("must be one of the files sent along"));
    }
    return files_->meshes(uri);
  });
  EXPECT_EQ(robot.status().message(),
            "urdf: link \"panda_link3\": collision: geometry: mesh filename is "
            "\"package://meshes/collision/link3.obj\": must be one of the files sent along");
}

}  // namespace
}  // namespace cwm::collision
