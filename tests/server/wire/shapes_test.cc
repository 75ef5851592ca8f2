#include "server/wire/shapes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "tests/server/wire/wire_test_values.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

TriangleMesh Tetrahedron() {
  return {.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          .triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
}

std::vector<Shape> EveryShape() {
  return {Sphere{0.1},
          Box{{0.1, 0.2, 0.3}},
          Cylinder{0.1, 0.4},
          Cone{0.2, 0, 0.3},
          Capsule{0.05, 0.5},
          HalfSpace{},
          Plate{.outline = {{0, 0}, {4, 0}, {4, 3}, {0, 3}},
                .holes = {{{1, 1}, {2, 1}, {2, 2}}},
                .thickness_m = 0.02},
          Convex{std::make_shared<const TriangleMesh>(ConvexHull3(Tetrahedron().vertices))},
          MakeMesh(Tetrahedron())};
}

TEST(WireShape, EveryShapeSurvivesARoundTrip) {
  GeometryStore store(kStoreBytes);
  const auto shapes = EveryShape();
  ASSERT_EQ(shapes.size(), static_cast<std::size_t>(kShapeKindCount));
  for (const Shape& shape : shapes) {
    const Placed<> placed{MakeTranslation(1, 2, 3), shape};
    const auto back = PlacedShapeFromProto(PlacedShapeToProto(placed, store), store, {});
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(back->shape, shape) << NameOf(KindOf(shape));
    EXPECT_TRUE(back->X_FS.isApprox(placed.X_FS));
  }
}

TEST(WireShape, VesselsAreMeshesThatTellTheirRimAndTheirWall) {
  GeometryStore store(kStoreBytes);
  const auto mug = std::make_shared<const VesselShell>(
      VesselShell{.outer = {{0.035, -0.04}, {0.04, 0.04}},
                  .inner = {{0.036, 0.04}, {0.031, -0.034}, {0, -0.034}},
                  .wall_thickness_m = 0.004,
                  .rim_radius_sigma_m = 0.0008});
  const ShapePart part{.shape = MakeMesh(Tessellate(*mug, 3e-4)), .vessel = mug};
  const v1::ShapePart proto = ShapePartToProto(part, store);
  ASSERT_TRUE(proto.has_vessel());
  EXPECT_TRUE(store.Get(proto.mesh().hash()).ok());
  EXPECT_EQ(proto.vessel().rim_radius_m(), 0.04);
  EXPECT_EQ(proto.vessel().foot_radius_m(), 0.035);
  EXPECT_NEAR(proto.vessel().height_m(), 0.08, 1e-12);
  EXPECT_NEAR(proto.vessel().depth_m(), 0.074, 1e-12);
  EXPECT_EQ(proto.vessel().wall_thickness_m(), 0.004);
  EXPECT_EQ(proto.vessel().rim_radius_sigma_m(), 0.0008);
  EXPECT_FALSE(proto.vessel().has_wall_thickness_sigma_m());
  ASSERT_EQ(proto.vessel().inner_profile_size(), 3);
  EXPECT_EQ(proto.vessel().inner_profile(1).x(), 0.031);
  EXPECT_EQ(proto.vessel().outer_profile_size(), 2);
  // Vessels put by a user have no descriptor: they are read as meshes.
  const auto back = ShapePartFromProto(proto, store, {});
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->vessel, nullptr);
  EXPECT_EQ(back->shape, part.shape);
}

TEST(WireShape, PartsKeepTheirRoleAndLoseTheirFit) {
  GeometryStore store(kStoreBytes);
  const ShapePart part{
      .X_OS = Pose::Identity(),
      .shape = Cylinder{0.1, 0.2},
      .role = PartRole::kCompleted,
      .fit = FitQuality{.rms_m = 0.001, .inlier_count = 7, .parameter_sigma = {1}}};
  const v1::ShapePart proto = ShapePartToProto(part, store);
  EXPECT_EQ(proto.fit().inlier_count(), 7);
  EXPECT_EQ(proto.coefficients_size(), 7);  // point, axis, radius
  const auto back = ShapePartFromProto(proto, store, {});
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->role, PartRole::kCompleted);
  EXPECT_FALSE(back->fit.has_value());  // a client's shape is not a measurement
}

TEST(WireShape, PartsKeepTheirHiddenSpace) {
  GeometryStore store(kStoreBytes);
  const ShapePart part{
      .X_OS = Pose::Identity(),
      .shape = Box{{0.1, 0.2, 0.005}},
      .hidden = Placed<Box>{.X_FS = MakeTranslation(0, 0, -0.1), .shape = {{0.1, 0.2, 0.2}}}};
  v1::ShapePart proto = ShapePartToProto(part, store);
  EXPECT_EQ(proto.hidden().box().size_z_m(), 0.2);
  EXPECT_EQ(proto.hidden().x_object_box().tz_m(), -0.1);
  const auto back = ShapePartFromProto(proto, store, {});
  ASSERT_TRUE(back.ok()) << back.status();
  ASSERT_TRUE(back->hidden);
  EXPECT_EQ(back->hidden->shape, part.hidden->shape);
  EXPECT_EQ(back->hidden->X_FS.translation(), part.hidden->X_FS.translation());
  proto.mutable_hidden()->mutable_box()->set_size_z_m(-1);
  const FieldPath root;
  const auto refused = ShapePartFromProto(proto, store, root.Field("part"));
  EXPECT_THAT(refused.status().message(), ::testing::HasSubstr("part.hidden.box"));
  EXPECT_THAT(refused.status().message(), ::testing::HasSubstr("-1"));
}

TEST(WireShape, RefusesBrokenDimensionsByTheirField) {
  struct Case {
    std::function<void(v1::PlacedShape&)> make;
    std::string field;
  };
  const std::vector<Case> cases = {
      {[](auto& s) { s.mutable_sphere()->set_radius_m(0); }, "s.sphere.radius_m"},
      {[](auto& s) { s.mutable_sphere()->set_radius_m(-1); }, "s.sphere.radius_m"},
      {[](auto& s) { s.mutable_sphere()->set_radius_m(kNan); }, "s.sphere.radius_m"},
      {[](auto& s) { s.mutable_sphere()->set_radius_m(1e30); }, "s.sphere.radius_m"},
      {[](auto& s) { s.mutable_box()->set_size_x_m(1); }, "s.box.size_y_m"},
      {[](auto& s) { s.mutable_cylinder()->set_radius_m(1); }, "s.cylinder.length_m"},
      {[](auto& s) { s.mutable_cone()->set_length_m(1); }, "s.cone.radius_bottom_m"},
      {[](auto& s) { s.mutable_capsule()->set_length_m(1); }, "s.capsule.radius_m"},
      {[](auto& s) { s.mutable_plate()->set_thickness_m(1); }, "s.plate.outline"},
      {[](auto& s) {
         s.mutable_plate()->set_thickness_m(1);
         for (const double x : {0.0, 1.0, kNan}) {
           s.mutable_plate()->mutable_outline()->add_vertices()->set_x(x);
         }
       },
       "s.plate.outline.vertices[2].x"},
      {[](auto& s) { s.mutable_mesh(); }, "s.mesh.hash"},
      {[](auto& s) { s.mutable_convex(); }, "s.convex.hash"},
      {[](auto&) {}, "s.shape"},
      {[](auto& s) {
         s.mutable_half_space();
         s.mutable_x_body_shape();
       },
       "s.x_body_shape.qx..qw"},
  };
  GeometryStore store(kStoreBytes);
  const FieldPath root;
  for (const Case& c : cases) {
    v1::PlacedShape shape;
    c.make(shape);
    const auto refused = PlacedShapeFromProto(shape, store, root.Field("s"));
    EXPECT_EQ(FieldAtFault(refused.status()), c.field) << refused.status();
  }
}

TEST(WireShape, AMeshThatOnlyARepeatedTriangleOpensIsASolid) {
  GeometryStore store(kStoreBytes);
  const auto put = [&](const TriangleMesh& mesh) {
    const auto held = std::make_shared<const TriangleMesh>(mesh);
    v1::PlacedShape shape;
    shape.mutable_mesh()->set_hash(store.RegisterMesh(held));
    const FieldPath root;
    const auto placed = PlacedShapeFromProto(shape, store, root.Field("s"));
    EXPECT_TRUE(placed.ok()) << placed.status();
    return std::get<Mesh>(placed->shape);
  };
  TriangleMesh mesh = Tetrahedron();
  mesh.triangles.push_back(mesh.triangles.front());
  const Mesh closed = put(mesh);
  EXPECT_TRUE(closed.watertight);
  EXPECT_EQ(closed.mesh->triangles.size(), 4u);
  mesh.triangles.resize(3);
  EXPECT_FALSE(put(mesh).watertight) << "a hole stays one";
}

TEST(WireShape, UnknownGeometryIsNotFoundAndNamed) {
  GeometryStore store(kStoreBytes);
  v1::PlacedShape shape;
  shape.mutable_mesh()->set_hash(std::string(64, 'a'));
  const FieldPath root;
  const auto refused = PlacedShapeFromProto(shape, store, root.Field("s"));
  EXPECT_TRUE(absl::IsNotFound(refused.status()));
  EXPECT_EQ(DetailsOf(refused.status()).reason, "GEOMETRY_UNKNOWN");
  EXPECT_THAT(TextOf(refused.status()), HasSubstr("s.mesh.hash: is aaaa"));
}

TEST(WireShape, LabelsAreNoMesh) {
  GeometryStore store(kStoreBytes);
  const auto stored = store.Put(BlobFormat::kLabelsU32, std::string(8, '\0'));
  ASSERT_TRUE(stored.ok());
  v1::PlacedShape shape;
  shape.mutable_mesh()->set_hash(stored->hash);
  EXPECT_EQ(FieldAtFault(PlacedShapeFromProto(shape, store, {}).status()), "mesh.hash");
}

TEST(WireShape, AFlatMeshHasNoHull) {
  GeometryStore store(kStoreBytes);
  const TriangleMesh flat{.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}};
  const auto stored = store.Put(BlobFormat::kMeshF64, EncodeMesh(flat));
  ASSERT_TRUE(stored.ok());
  v1::PlacedShape shape;
  shape.mutable_convex()->set_hash(stored->hash);
  EXPECT_EQ(FieldAtFault(PlacedShapeFromProto(shape, store, {}).status()), "convex.hash");
}

}  // namespace
}  // namespace cwm::server
