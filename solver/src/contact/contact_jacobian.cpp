#include "contact/contact_jacobian.hpp"

#include <algorithm>
#include <cmath>

#include "base/index.hpp"

namespace quoin::solver {

void tangent_frame(const BodyContact& contact, const Vector3& normal, Vector3& t1, Vector3& t2) {
  t1 = normal.cross(contact.axis()).normalized();
  t2 = normal.cross(t1);
}

namespace {

struct Rows {
  Vector3 normal, t1, t2;
};

/// Normal and tangents; minus these on A.
Matrix3 frame_of(const Rows& rows, double sign) {
  Matrix3 frame;
  frame << rows.normal.transpose(), rows.t1.transpose(), rows.t2.transpose();
  return sign * frame;
}

/// Of a block that does not move in this step.
void fill_still(const Rows& rows, double sign, ContactJacobian& jacobian) {
  jacobian.rigid << frame_of(rows, sign), Matrix3::Zero();
  if (jacobian.strain) jacobian.strain.make().setZero();
}

/// `at_point`, `at_anchor`: mean_motion of the two; the strain's columns are zero unless it
/// deforms.
void fill(const Rows& rows, double sign, const Matrix3x12& at_point, const Matrix3x12& at_anchor,
          bool deforms, ContactJacobian& jacobian) {
  const Matrix3 frame = frame_of(rows, sign);
  const Matrix3 point = frame * at_point.middleCols<3>(3);
  Matrix3 turned = frame * at_anchor.middleCols<3>(3);
  turned.row(0) = point.row(0);
  jacobian.rigid << frame, turned;
  if (!deforms) {
    if (jacobian.strain) jacobian.strain.make().setZero();
    return;
  }
  Matrix3x6& strain = jacobian.strain.make();
  const Matrix3x6 strained = frame * at_point.rightCols<6>();
  strain = frame * at_anchor.rightCols<6>();
  strain.row(0) = strained.row(0);
}

/// `turn`: how a row grows with the block's turn, world's axes.
void add_to_row(int row, const Vector3& turn, const Matrix3& rotation, ContactJacobian& jacobian) {
  const Vector3 own = rotation.transpose() * turn;
  for (int k = 0; k < 3; ++k) jacobian.rigid(row, 3 + k) += own[k];
}

/// The normal turns with its face, (r × n)·m = (n × m)·r, or with both crossed edges:
/// dn = -(n·de_a) e_a* - (n·de_b) e_b*, de = r × e, with e_a*, e_b* dual to e_a, e_b in the plane.
void add_turn(const BodyContact& contact, const ContactGeometry& mean, const Vector3& lever,
              const Matrix3& rotation_a, const Matrix3& rotation_b, LinearContact& linear) {
  const Vector3& n = mean.normal;
  if (!contact.crossed) {
    if (contact.normal_on_a)
      add_to_row(0, n.cross(lever), rotation_a, linear.jacobian_a);
    else
      add_to_row(0, n.cross(lever), rotation_b, linear.jacobian_b);
    return;
  }
  const Vector3 across_a = mean.edge_a.cross(n), across_b = mean.edge_b.cross(n);
  const Vector3 turn_a = -across_b.dot(lever) / across_b.dot(mean.edge_a) * across_a;
  const Vector3 turn_b = -across_a.dot(lever) / across_a.dot(mean.edge_b) * across_b;
  // Mean edges are normal to the mean normal to second order of the turn only. What the moments of
  // both miss then is theirs by halves: angular momentum is kept.
  const Vector3 missing = 0.5 * (n.cross(lever) - turn_a - turn_b);
  add_to_row(0, turn_a + missing, rotation_a, linear.jacobian_a);
  add_to_row(0, turn_b + missing, rotation_b, linear.jacobian_b);
}

/// The tangents turn with the owner of the normal: (r × t)·m as above, so that shear forces on
/// points that stand apart by m (a gap, an overlap, a stretched spring) keep angular momentum.
void add_tangent_turn(const BodyContact& contact, const Rows& rows, const Vector3& lever,
                      const Matrix3& rotation, LinearContact& linear) {
  ContactJacobian& jacobian = contact.normal_on_a ? linear.jacobian_a : linear.jacobian_b;
  add_to_row(1, rows.t1.cross(lever), rotation, jacobian);
  add_to_row(2, rows.t2.cross(lever), rotation, jacobian);
}

}  // namespace

Vector3 half_turn(const BodyContact& contact, const StepPoses& poses) {
  const std::size_t owner = index(contact.normal_on_a ? contact.a : contact.b);
  return 0.5 * (poses.start[owner].rotation * poses.increment[owner].segment<3>(3));
}

void linearise(const BodyContact& contact, const StepPoses& poses,
               std::span<const BlockModel> models, LinearContact& linear) {
  const std::size_t a = index(contact.a), b = index(contact.b);
  const Pose &start_a = poses.start[a], &start_b = poses.start[b];
  const Pose &end_a = poses.end[a], &end_b = poses.end[b];
  const ContactGeometry before = contact_geometry(contact, start_a, start_b);
  const ContactGeometry after = contact_geometry(contact, end_a, end_b);
  Rows rows;
  rows.normal = 0.5 * (before.normal + after.normal);
  tangent_frame(contact, rows.normal, rows.t1, rows.t2);
  const auto fill_side = [&](std::size_t block, double sign, const Vector3& arm,
                             const Vector3& anchor, ContactJacobian& jacobian) {
    if (!poses.moves[block]) return fill_still(rows, sign, jacobian);
    const bool deforms = poses.deforms[block] != 0;
    const auto mean = [&](const Vector3& place) {
      return mean_motion(poses.start[block], poses.end[block], poses.increment[block].segment<3>(3),
                         place, deforms);
    };
    const Matrix3x12 at_point = mean(arm);
    fill(rows, sign, at_point, anchor == arm ? at_point : mean(anchor), deforms, jacobian);
  };
  fill_side(a, -1.0, contact.arm_a, contact.state.anchor_a, linear.jacobian_a);
  fill_side(b, 1.0, contact.arm_b, contact.state.anchor_b, linear.jacobian_b);
  linear.rounding = before.rounding();
  const Vector3 lever = 0.5 * (before.place_b - before.place_a + after.place_b - after.place_a);
  ContactGeometry middle;
  middle.normal = rows.normal;
  middle.edge_a = 0.5 * (before.edge_a + after.edge_a);
  middle.edge_b = 0.5 * (before.edge_b + after.edge_b);
  add_turn(contact, middle, lever, start_a.rotation, start_b.rotation, linear);
  const Vector3 stretched = before.between + (start_b.shape * contact.state.anchor_b -
                                              start_a.shape * contact.state.anchor_a);
  const Vector3 stretched_end =
      after.between + (end_b.shape * contact.state.anchor_b - end_a.shape * contact.state.anchor_a);
  const std::size_t owner = contact.normal_on_a ? a : b;
  const Matrix3& turning = poses.start[owner].rotation;
  add_tangent_turn(contact, rows, 0.5 * (stretched + stretched_end), turning, linear);
  // The tangents of the start: half the turn back from those of the middle.
  const Vector3 back = -half_turn(contact, poses);
  linear.offset =
      Vector3(before.gap - contact.opening, (rows.t1 + back.cross(rows.t1)).dot(stretched),
              (rows.t2 + back.cross(rows.t2)).dot(stretched));
  for (double& value : linear.offset)
    if (std::abs(value) <= linear.rounding) value = 0.0;
  if (contact.state.spring_area > 0.0) {  // tangents turned back are its tangents nearly
    const Vector3 along = stretched - stretched.dot(before.normal) * before.normal;
    const double size = linear.offset.tail<2>().norm();
    if (size > 0.0) linear.offset.tail<2>() *= along.norm() / size;
  }
  linear.start = linear.offset;
  if (contact.crossed) {
    const double predicted = before.gap + linear.jacobian_a.normal(poses.increment[a]) +
                             linear.jacobian_b.normal(poses.increment[b]);
    const double correction = after.gap - predicted;
    if (std::abs(correction - linear.turn_correction) > 4.0 * linear.rounding)
      linear.turn_correction = correction;
    linear.offset[0] += linear.turn_correction;
  }
  if (models[a].unknowns == 0) linear.offset += linear.jacobian_a * poses.increment[a];
  if (models[b].unknowns == 0) linear.offset += linear.jacobian_b * poses.increment[b];
}

namespace {

/// The same over the stiffness of their strain alone: what lets stiff blocks (E 1e12) settle in a
/// few solves. It was not varied.
constexpr double kStrainAugmentation = 1e2;

/// A row of J, or of its strain alone.
Vector12 row_of(const ContactJacobian& jacobian, int row, bool strain_alone) {
  Vector12 result = jacobian.push(Vector3::Unit(row));
  if (strain_alone) result.head<6>().setZero();
  return result;
}

/// J M Jᵀ of the two tangential rows.
Eigen::Matrix2d tangential(const SquareBlocks& matrix, std::size_t slot,
                           const ContactJacobian& jacobian, bool strain_alone = false) {
  const Vector12 t1 = row_of(jacobian, 1, strain_alone), t2 = row_of(jacobian, 2, strain_alone);
  const Vector12 by_1 = matrix.times(slot, t1), by_2 = matrix.times(slot, t2);
  Eigen::Matrix2d result;
  result << t1.dot(by_1), t1.dot(by_2), t2.dot(by_1), t2.dot(by_2);
  return result;
}

/// J M Jᵀ of the normal row.
double square(const SquareBlocks& matrix, std::size_t slot, const ContactJacobian& jacobian,
              bool strain_alone = false) {
  const Vector12 row = row_of(jacobian, 0, strain_alone);
  return row.dot(matrix.times(slot, row));
}

/// Of a symmetric matrix.
double largest_eigenvalue(const Eigen::Matrix2d& m) {
  return 0.5 * (m(0, 0) + m(1, 1)) + Eigen::Vector2d(0.5 * (m(0, 0) - m(1, 1)), m(0, 1)).norm();
}

double augmentation(double compliance, double strain_compliance) {
  return kAugmentation / compliance +
         (strain_compliance > 0.0 ? kStrainAugmentation / strain_compliance : 0.0);
}

}  // namespace

double normal_compliance(const LinearContact& c, const SquareBlocks& compliance) {
  double sum = 0.0;
  c.each_side([&](std::size_t slot, const ContactJacobian& jacobian) {
    sum += square(compliance, slot, jacobian);
  });
  return sum;
}

double shear_compliance(const LinearContact& c, const SquareBlocks& compliance) {
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  c.each_side([&](std::size_t slot, const ContactJacobian& jacobian) {
    sum += tangential(compliance, slot, jacobian);
  });
  return largest_eigenvalue(sum);
}

void set_augmentation(const SquareBlocks& compliance, LinearContact& linear) {
  double strain = 0.0;
  Eigen::Matrix2d strain_shear = Eigen::Matrix2d::Zero();
  linear.each_side([&](std::size_t slot, const ContactJacobian& jacobian) {
    if (!jacobian.deforms()) return;
    strain += square(compliance, slot, jacobian, true);
    strain_shear += tangential(compliance, slot, jacobian, true);
  });
  linear.normal_stiffness = augmentation(normal_compliance(linear, compliance), strain);
  linear.shear_stiffness = 0.0;
  if (linear.law == ContactLaw::Frictionless) return;
  linear.shear_stiffness =
      augmentation(shear_compliance(linear, compliance), largest_eigenvalue(strain_shear));
}

void linearise_velocity(const BodyContact& contact, const StepPoses& poses, LinearContact& linear) {
  const std::size_t a = index(contact.a), b = index(contact.b);
  const ContactGeometry now = contact_geometry(contact, poses.end[a], poses.end[b]);
  Rows rows;
  rows.normal = now.normal;
  tangent_frame(contact, rows.normal, rows.t1, rows.t2);
  const auto fill_side = [&](std::size_t block, double sign, const Vector3& arm,
                             ContactJacobian& jacobian) {
    if (!poses.moves[block]) return fill_still(rows, sign, jacobian);
    const bool deforms = poses.deforms[block] != 0;
    const Matrix3x12 at_point = motion(poses.end[block], arm, deforms);
    fill(rows, sign, at_point, at_point, deforms, jacobian);
  };
  fill_side(a, -1.0, contact.arm_a, linear.jacobian_a);
  fill_side(b, 1.0, contact.arm_b, linear.jacobian_b);
  const Vector3 lever = now.place_b - now.place_a;
  add_turn(contact, now, lever, poses.end[a].rotation, poses.end[b].rotation, linear);
  add_tangent_turn(contact, rows, lever, poses.end[contact.normal_on_a ? a : b].rotation, linear);
  linear.offset.setZero();
}

}  // namespace quoin::solver
