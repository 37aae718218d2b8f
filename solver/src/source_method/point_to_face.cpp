#include "source_method/point_to_face.hpp"

namespace quoin::solver {

Vector3 between_after(const PointToFace& contact, const Vector12& d_i, const Vector12& d_j) {
  return contact.between + contact.motion_i * d_i - contact.motion_j * d_j;
}

ContactBlocks normal_blocks(const PointToFace& contact, double stiffness, double multiplier) {
  const Vector12 h = contact.motion_i.transpose() * contact.normal;  // (26)
  const Vector12 q = contact.motion_j.transpose() * contact.normal;  // (27)
  const double gap = contact.normal.dot(contact.between);            // (25)
  ContactBlocks blocks;
  blocks.ii = stiffness * h * h.transpose();
  blocks.ij = -stiffness * h * q.transpose();
  blocks.jj = stiffness * q * q.transpose();
  blocks.force.i = -(multiplier + stiffness * gap) * h;
  blocks.force.j = (multiplier + stiffness * gap) * q;
  return blocks;
}

ContactForces multiplier_forces(const PointToFace& contact, double multiplier) {
  const Vector3 push = multiplier * contact.normal;
  return {-contact.motion_i.transpose() * push, contact.motion_j.transpose() * push};
}

ContactBlocks shear_blocks(const PointToFace& contact, double stiffness) {
  const Vector3& n = contact.normal;
  const Matrix3 tangential = Matrix3::Identity() - n * n.transpose();
  const Matrix3x12 on_i = tangential * contact.motion_i, on_j = tangential * contact.motion_j;
  ContactBlocks blocks;
  blocks.ii = stiffness * contact.motion_i.transpose() * on_i;
  blocks.ij = -stiffness * contact.motion_i.transpose() * on_j;
  blocks.jj = stiffness * contact.motion_j.transpose() * on_j;
  blocks.force.i = -stiffness * on_i.transpose() * contact.between;
  blocks.force.j = stiffness * on_j.transpose() * contact.between;
  return blocks;
}

ContactForces friction_forces(const PointToFace& contact, double friction,
                              const Vector3& direction) {
  return {-friction * contact.motion_i.transpose() * direction,
          friction * contact.motion_j.transpose() * direction};
}

}  // namespace quoin::solver
