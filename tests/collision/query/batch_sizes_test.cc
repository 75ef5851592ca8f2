// The answer for a row does not depend on the other rows of the batch, whichever way the rows are
// answered.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "collision/geometry/tessellate.h"
#include "collision/query/robot_body.h"
#include "collision/query/sphere_check.h"
#include "collision/robot/kinematics.h"
#include "tests/collision/mesh_files/mesh_bytes.h"
#include "tests/collision/query/room_of_all_kinds.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using testing::JointText;

// The columns of several batches, one after the other.
struct Answers {
  std::vector<Verdict> verdict;
  std::vector<std::int32_t> object, body_part, object_part, variable;
  std::vector<Accuracy> accuracy;

  void Add(const CollisionColumns& more) {
    const auto append = [](auto& to, const auto& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    append(verdict, more.verdict);
    append(object, more.object);
    append(body_part, more.body_part);
    append(object_part, more.object_part);
    append(accuracy, more.accuracy);
    append(variable, more.variable);
    variable.resize(verdict.size(), -1);  // batches without rows out of limits
  }
};

TriangleMesh OpenBox(const Vector3& size_m) {
  TriangleMesh mesh = testing::BoxMesh(size_m);
  mesh.triangles.pop_back();
  return mesh;
}

// Four rotary joints in a chain, with a box, a cylinder, a ball and the mesh of the file
// "link.stl".
std::shared_ptr<const RobotModel> ArmWith(const TriangleMesh& mesh) {
  const auto link = [](const std::string& name, const std::string& geometry) {
    return "<link name=\"" + name + "\"><collision><origin xyz=\"0 0 0.1\"/><geometry>" + geometry +
           "</geometry></collision></link>";
  };
  const auto turn = [](const std::string& axis) {
    return "<origin xyz=\"0.05 0 0.22\" rpy=\"0.2 0.1 0\"/><axis xyz=\"" + axis +
           "\"/><limit lower=\"-2.4\" upper=\"2.4\"/>";
  };
  const std::string text = link("a", "<box size=\"0.1 0.12 0.2\"/>") +
                           link("b", "<cylinder radius=\"0.04\" length=\"0.2\"/>") +
                           link("c", "<mesh filename=\"link.stl\"/>") +
                           link("d", "<sphere radius=\"0.05\"/>") +
                           link("e", "<box size=\"0.05 0.1 0.15\"/>") +
                           JointText("j", "revolute", "a", "b", turn("0 0 1")) +
                           JointText("k", "revolute", "b", "c", turn("0 1 0")) +
                           JointText("l", "revolute", "c", "d", turn("1 0 0")) +
                           JointText("m", "revolute", "d", "e", turn("0 1 0"));
  const auto read = [&](std::string_view) -> absl::StatusOr<std::string> {
    return testing::BinaryStl(mesh);
  };
  const auto description = ReadUrdf(testing::Robot(text), read);
  EXPECT_TRUE(description.ok()) << description.status();
  return *MakeRobotModel(*description, nullptr);
}

// Shapes of all kinds around the arm, none at its base, including open meshes as in scans.
std::shared_ptr<const WorldSnapshot> Room(std::mt19937& random) {
  std::vector<Change> changes;
  const auto put = [&](const std::string& name, const Shape& shape) {
    Pose X_WO = RandomPose(random, 0.6);
    const double out_m = X_WO.translation().norm();
    if (out_m < 0.5) X_WO.translation() *= 0.5 / out_m;
    changes.push_back(PutOf(name, {{.X_FS = Pose::Identity(), .shape = shape}}, X_WO));
  };
  for (std::size_t i = 0; i < Catalogue().size(); ++i) {
    const Shape& shape = Catalogue()[i].shape;
    if (KindOf(shape) != ShapeKind::kHalfSpace) put("object" + std::to_string(i), shape);
  }
  for (int k = 0; k < 4; ++k) {
    put("open" + std::to_string(k), MakeMesh(OpenBox({0.1, 0.05, 0.15})));
  }
  return WorldOf(changes);
}

class BatchSizes : public ::testing::Test {
 protected:
  // Checks all rows in batches of each size, which must give the same answers. Returns the
  // accuracies of free rows.
  std::set<Accuracy> ExpectSameInAnyBatch(const WorldSnapshot& world, const QueryBody& body,
                                          const RobotModel& model, const QueryOptions& options) {
    const std::size_t width = model.all.variables.size();
    std::vector<double> rows;
    for (std::size_t k = 0; k < kRows * width; ++k) {
      rows.push_back(std::uniform_real_distribution<double>(-2.5, 2.5)(random_));
    }
    const auto rows_of = [&](std::size_t first, std::size_t count) {
      return JointRows(
          model, model.all,
          {.X_WB = Pose::Identity(),
           .base = DefaultVariables(model),
           .rows = std::span<const double>(rows).subspan(first * width, count * width)});
    };
    EXPECT_TRUE(SphereCheck::Make(world, body, rows_of(0, kRows), options).has_value());
    Answers single;
    for (std::size_t k = 0; k < kRows; ++k) {
      single.Add(*CheckCollisions(world, body, rows_of(k, 1), options));
    }
    for (const std::size_t size : {std::size_t{7}, std::size_t{255}, std::size_t{256}, kRows}) {
      Answers together;
      for (std::size_t first = 0; first < kRows; first += size) {
        const std::size_t count = std::min(size, kRows - first);
        together.Add(*CheckCollisions(world, body, rows_of(first, count), options));
      }
      EXPECT_EQ(together.verdict, single.verdict) << size;
      EXPECT_EQ(together.object, single.object) << size;
      EXPECT_EQ(together.body_part, single.body_part) << size;
      EXPECT_EQ(together.object_part, single.object_part) << size;
      EXPECT_EQ(together.accuracy, single.accuracy) << size;
      EXPECT_EQ(together.variable, single.variable) << size;
    }
    std::set<Accuracy> of_free;
    for (std::size_t k = 0; k < kRows; ++k) {
      if (single.verdict[k] == Verdict::kFree) of_free.insert(single.accuracy[k]);
    }
    return of_free;
  }

  static constexpr std::size_t kRows = 2000;
  std::mt19937 random_{17};
};

TEST_F(BatchSizes, DoNotMatterToARobotOfShapesAmongOpenSurfaces) {
  const auto model = ArmWith(testing::BoxMesh({0.05, 0.04, 0.2}));
  const auto robot = PrepareRobot(model, std::nullopt);
  const auto world = Room(random_);
  for (const double margin_m : {0.0, 0.02}) {
    for (const RobotScope scope : {RobotScope::kBoth, RobotScope::kWorld}) {
      const auto of_free = ExpectSameInAnyBatch(*world, BodyFromRobot(*robot, scope), *model,
                                                {.margin_m = margin_m});
      EXPECT_EQ(of_free, (std::set<Accuracy>{Accuracy::kExact, Accuracy::kSurfaceOnly}));
    }
  }
}

TEST_F(BatchSizes, DoNotMatterToARobotWithAnOpenSurface) {
  const auto model = ArmWith(OpenBox({0.05, 0.04, 0.2}));
  const auto robot = PrepareRobot(model, std::nullopt);
  const auto world = Room(random_);
  for (const RobotScope scope : {RobotScope::kBoth, RobotScope::kSelf}) {
    const auto of_free = ExpectSameInAnyBatch(*world, BodyFromRobot(*robot, scope), *model, {});
    EXPECT_EQ(of_free, (std::set<Accuracy>{Accuracy::kExact, Accuracy::kSurfaceOnly}));
  }
}

TEST_F(BatchSizes, DoNotMatterWhereRulesAndNamesLeaveThingsOut) {
  const auto model = ArmWith(testing::BoxMesh({0.05, 0.04, 0.2}));
  const auto robot = PrepareRobot(model, std::nullopt);
  const auto world = Room(random_);
  QueryOptions options;
  options.ignore = {"open0", "object3"};
  options.ignore_pairs = {{.a = {.name = "open1"}, .b = {.name = "*"}}};
  ExpectSameInAnyBatch(*world, BodyFromRobot(*robot, RobotScope::kBoth), *model, options);
}

TEST_F(BatchSizes, DoNotMatterToARobotOfSpheres) {
  const auto model = ArmWith(testing::BoxMesh({0.05, 0.04, 0.2}));
  const auto robot = PrepareRobot(model, std::nullopt);
  const auto world = Room(random_);
  QueryBody body = BodyFromSpheres(*robot, *robot->bounding_spheres, RobotScope::kBoth);
  ExpectSameInAnyBatch(*world, body, *model, {});
  // The same for a body whose spheres are the robot itself.
  body.best_accuracy = Accuracy::kExact;
  const auto of_free = ExpectSameInAnyBatch(*world, body, *model, {});
  EXPECT_EQ(of_free, (std::set<Accuracy>{Accuracy::kExact, Accuracy::kSurfaceOnly}));
}

}  // namespace
}  // namespace cwm::collision
