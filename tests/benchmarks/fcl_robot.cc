#include "tests/benchmarks/fcl_robot.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/collision_object.h>

#include <vector>

namespace cwm::benchmarks {
namespace {

using FclObject = fcl::CollisionObject<double>;
using FclMesh = fcl::BVHModel<fcl::OBB<double>>;

std::shared_ptr<fcl::CollisionGeometry<double>> MeshOf(const TriangleMesh& mesh) {
  std::vector<fcl::Triangle> triangles;
  for (const auto& [a, b, c] : mesh.triangles) triangles.emplace_back(a, b, c);
  auto model = std::make_shared<FclMesh>();
  model->beginModel();
  model->addSubModel(mesh.vertices, triangles);
  model->endModel();
  return model;
}

std::shared_ptr<fcl::CollisionGeometry<double>> GeometryOf(const Shape& shape) {
  if (const auto* box = std::get_if<Box>(&shape)) {
    return std::make_shared<fcl::Box<double>>(box->size_m);
  }
  if (const auto* sphere = std::get_if<Sphere>(&shape)) {
    return std::make_shared<fcl::Sphere<double>>(sphere->radius_m);
  }
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
    return std::make_shared<fcl::Cylinder<double>>(cylinder->radius_m, cylinder->length_m);
  }
  return MeshOf(*std::get<Mesh>(shape).mesh);
}

bool Collide(const FclObject& a, const FclObject& b) {
  static const fcl::CollisionRequest<double> request;
  fcl::CollisionResult<double> result;
  return fcl::collide(&a, &b, request, result) > 0;
}

bool StopAtFirst(FclObject* a, FclObject* b, void* found) {
  auto& collides = *static_cast<bool*>(found);
  collides = collides || Collide(*a, *b);
  return collides;
}

}  // namespace

struct FclRobot::State {
  const collision::QueryBody& body;
  std::vector<FclObject> parts;
  std::vector<std::unique_ptr<FclObject>> world;
  fcl::DynamicAABBTreeCollisionManager<double> tree;

  void Move(std::span<const Pose> X_WF) {
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const auto frame = static_cast<std::size_t>(body.frame_of_part[k]);
      parts[k].setTransform(X_WF[frame] * body.geometry->parts[k].X_OP);
    }
  }
};

FclRobot::FclRobot(const collision::QueryBody& body, const collision::WorldSnapshot& world)
    : state_(new State{.body = body, .parts = {}, .world = {}, .tree = {}}) {
  for (const collision::PreparedPart& part : body.geometry->parts) {
    state_->parts.emplace_back(GeometryOf(part.shape));
  }
  for (const collision::WorldObjectPtr& object : world.objects()) {
    for (std::size_t k = 0; k < object->parts_W.size(); ++k) {
      state_->world.push_back(std::make_unique<FclObject>(
          GeometryOf(object->geometry->parts[k].shape), object->parts_W[k].X_WP));
      state_->world.back()->computeAABB();
      state_->tree.registerObject(state_->world.back().get());
    }
  }
  state_->tree.setup();
}

FclRobot::~FclRobot() = default;

bool FclRobot::CollidesPlainly(std::span<const Pose> X_WF) {
  state_->Move(X_WF);
  for (const auto& [first, second] : state_->body.self_pairs) {
    if (Collide(state_->parts[static_cast<std::size_t>(first)],
                state_->parts[static_cast<std::size_t>(second)])) {
      return true;
    }
  }
  for (const FclObject& part : state_->parts) {
    for (const auto& object : state_->world) {
      if (Collide(part, *object)) return true;
    }
  }
  return false;
}

bool FclRobot::CollidesByTree(std::span<const Pose> X_WF) {
  state_->Move(X_WF);
  for (FclObject& part : state_->parts) part.computeAABB();
  for (const auto& [first, second] : state_->body.self_pairs) {
    const FclObject& a = state_->parts[static_cast<std::size_t>(first)];
    const FclObject& b = state_->parts[static_cast<std::size_t>(second)];
    if (a.getAABB().overlap(b.getAABB()) && Collide(a, b)) return true;
  }
  bool collides = false;
  for (FclObject& part : state_->parts) {
    state_->tree.collide(&part, &collides, StopAtFirst);
    if (collides) return true;
  }
  return false;
}

bool FclRobot::PairCollides(const Pair& pair, const Vector3& offset_W) const {
  FclObject second = pair.is_self_pair ? state_->parts[pair.other] : *state_->world[pair.other];
  second.setTranslation(second.getTranslation() + offset_W);
  return Collide(state_->parts[pair.part], second);
}

}  // namespace cwm::benchmarks
