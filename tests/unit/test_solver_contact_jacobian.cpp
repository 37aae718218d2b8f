/// Gap and slip of a contact as the exact discrete derivative; action and reaction.

#include <quoin/geometry/build.hpp>

#include "solver/src/contact/contact_jacobian.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

Vector12 random_vector(Random& random, double size) {
  Vector12 v;
  for (double& x : v) x = random.uniform(-size, size);
  return v;
}

/// Two deformable cubes near each other, a contact between two of their material points and a step
/// of both, of any size.
struct Setting {
  Scene scene;
  std::vector<BlockModel> models;
  std::vector<BlockState> start;
  StepPoses poses;
  BodyContact contact;

  Setting(Random& random, double step, bool face_on_a, double gap) {
    scene.add_block(geometry::make_box({-1, -1, -1}, {1, 1, 1}), {.density = 1, .young = 1});
    scene.add_block(geometry::make_box({-1, -1, -1}, {1, 1, 1}), {.density = 1, .young = 1});
    poses.increment.resize(2);
    poses.deforms.assign(2, 1);
    poses.moves.assign(2, 1);
    for (int b = 0; b < 2; ++b) {
      const Block& made = scene.blocks[static_cast<std::size_t>(b)];
      models.push_back(make_block_model(made, reference_shape(*made.shape), Vector3::Zero(), b));
      BlockState block;
      const Vector12 v = random_vector(random, 1.0);
      block.centroid = v.head<3>() + Vector3(0, 0, 2.0 * b);
      block.rotation = cayley(v.segment<3>(3));
      block.strain = 0.05 * v.tail<6>();
      start.push_back(block);
      poses.start.push_back(pose(block));
      poses.increment[static_cast<std::size_t>(b)] = random_vector(random, step);
    }
    move();
    geometry::ContactPoint point;
    point.key = {0, 1, {geometry::FeatureKind::Vertex, 0}, {geometry::FeatureKind::Vertex, 0}};
    (face_on_a ? point.key.feature_a : point.key.feature_b).kind = geometry::FeatureKind::Face;
    point.normal = random_vector(random, 1.0).head<3>().normalized();
    point.point_a = 0.5 * random_vector(random, 1.0).head<3>();
    point.point_b = point.point_a + gap * point.normal;
    point.gap = gap;
    point.point_a = in_shape(0, point.point_a);
    point.point_b = in_shape(1, point.point_b);
    contact = make_body_contact({scene, models, poses.start}, point);
  }

  Vector3 in_shape(std::size_t block, const Vector3& place) const {
    const Pose& pose = poses.start[block];
    return reference_arm(pose, place - pose.centroid);
  }

  void move() {
    poses.end.clear();
    for (std::size_t b = 0; b < 2; ++b)
      poses.end.push_back(pose(displaced(start[b], poses.increment[b])));
  }

  Vector3 anchor_a(const std::vector<Pose>& at) const {
    return at[0].centroid + at[0].shape * contact.state.anchor_a;
  }
  Vector3 anchor_b(const std::vector<Pose>& at) const {
    return at[1].centroid + at[1].shape * contact.state.anchor_b;
  }

  Vector3 relative(const LinearContact& linear) const {
    return linear.offset + linear.jacobian_a * poses.increment[0] +
           linear.jacobian_b * poses.increment[1];
  }
};

}  // namespace

TEST_CASE("The gap at the end of a step is exactly offset + J D, for steps of any size") {
  Random random(11);
  for (int i = 0; i < 200; ++i) {
    const double step = i % 3 == 0 ? 0.7 : i % 3 == 1 ? 0.05 : 1e-4;
    Setting s(random, step, i % 2 == 0, random.uniform(-0.1, 0.1));
    LinearContact linear;
    linearise(s.contact, s.poses, s.models, linear);
    const ContactGeometry end = contact_geometry(s.contact, s.poses.end[0], s.poses.end[1]);
    CHECK_THAT(s.relative(linear)[0], WithinAbs(end.gap, 1e-13));
  }
}

TEST_CASE(
    "The slip at the end of a step is that of the anchors along tangents that turn with the face") {
  Random random(12);
  for (int i = 0; i < 100; ++i) {
    Setting s(random, i % 2 == 0 ? 0.3 : 1e-3, i % 4 < 2, 0.05);
    LinearContact linear;
    linearise(s.contact, s.poses, s.models, linear);
    const std::size_t owner = s.contact.normal_on_a ? 0 : 1;
    const Vector3 turn = s.poses.start[owner].rotation * s.poses.increment[owner].segment<3>(3);
    const Vector3 moved = s.anchor_b(s.poses.end) - s.anchor_a(s.poses.end);
    // Rows of J on the translation of B are the tangents at the middle of the step.
    for (int row = 1; row < 3; ++row) {
      const Vector3 middle = linear.jacobian_b.rigid.block<1, 3>(row, 0).transpose();
      const Vector3 end = middle + 0.5 * turn.cross(middle);
      CHECK_THAT(s.relative(linear)[row], WithinAbs(end.dot(moved), 1e-13));
    }
  }
}

TEST_CASE("Action equals reaction: forces and moments of a contact on both blocks cancel") {
  // V22: the reaction on the face's block acts at the contact, not at a vertex of the face. Moments
  // are taken about the world origin with the mean place of each centroid in the step. Shear
  // cancels too, though the two points stand a gap apart.
  Random random(14);
  for (int i = 0; i < 100; ++i) {
    Setting s(random, i % 2 == 0 ? 0.5 : 1e-3, i % 4 < 2, random.uniform(-0.1, 0.1));
    LinearContact linear;
    linearise(s.contact, s.poses, s.models, linear);
    for (int row = 0; row < 3; ++row) {
      Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
      for (std::size_t b = 0; b < 2; ++b) {
        const Matrix3x6& j = (b == 0 ? linear.jacobian_a : linear.jacobian_b).rigid;
        const Vector3 f = j.block<1, 3>(row, 0).transpose();
        const Vector3 middle = 0.5 * (s.poses.start[b].centroid + s.poses.end[b].centroid);
        force += f;
        moment += middle.cross(f) + s.poses.start[b].rotation * j.block<1, 3>(row, 3).transpose();
      }
      CHECK(force.norm() < 1e-14);
      CHECK(moment.norm() < 1e-13);
    }
  }
}

TEST_CASE("Velocity rows are the rates of gap and slip") {
  Random random(16);
  for (int i = 0; i < 20; ++i) {
    Setting s(random, 0.0, i % 2 == 0, 0.0);
    LinearContact linear;
    linearise_velocity(s.contact, s.poses, linear);
    const Vector12 va = random_vector(random, 1.0), vb = random_vector(random, 1.0);
    const double h = 1e-6;
    double gaps[2];
    for (const int sign : {0, 1}) {
      const double at = sign == 0 ? -h : h;
      s.poses.increment = {Vector12(at * va), Vector12(at * vb)};
      s.move();
      gaps[sign] = contact_geometry(s.contact, s.poses.end[0], s.poses.end[1]).gap;
    }
    const Vector3 rate = linear.jacobian_a * va + linear.jacobian_b * vb;
    CHECK_THAT(rate[0], WithinAbs((gaps[1] - gaps[0]) / (2 * h), 1e-8));
  }
}

TEST_CASE("Edges that turn past each other in a step are held along the pair's normal") {
  // Two cubes on each other; the upper one turns from 0.03 rad to -0.03 rad about the vertical, and
  // with it the normal of edges that were nearly parallel turns over.
  Random random(15);
  Setting s(random, 0.0, true, 0.0);
  s.start = {BlockState{}, BlockState{}};
  s.start[1].centroid = {0, 0, 2};
  s.start[1].rotation = cayley({0, 0, 0.03});
  s.poses.start = {pose(s.start[0]), pose(s.start[1])};
  s.poses.increment[1][5] = -0.06;
  s.move();
  geometry::ContactPoint point;
  point.normal = Vector3::UnitZ();
  point.point_a = {0, 0.9, 1};
  point.point_b = s.in_shape(1, point.point_a);
  int turned_over = 0;
  for (int edge = 0; edge < 144; ++edge) {
    point.key = {
        0, 1, {geometry::FeatureKind::Edge, edge / 12}, {geometry::FeatureKind::Edge, edge % 12}};
    BodyContact contact = make_body_contact({s.scene, s.models, s.poses.start}, point);
    if (!contact.crossed) continue;
    uncross_turned_edges({s.poses.start[0], s.poses.start[1]}, {s.poses.end[0], s.poses.end[1]},
                         contact);
    if (!contact.crossed) ++turned_over;
    LinearContact linear;
    linearise(contact, s.poses, s.models, linear);
    CHECK_THAT(linear.jacobian_b.rigid(0, 2), WithinAbs(1.0, 1e-12));
  }
  CHECK(turned_over == 32);  // of each cube four edges along x, four along y
}
