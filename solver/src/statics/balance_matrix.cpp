#include "statics/balance_matrix.hpp"

#include <algorithm>
#include <map>

#include "base/index.hpp"

namespace quoin::solver {

using Eigen::VectorXd;

namespace {

Slots rigid_slots(int count) {
  const auto n = static_cast<std::size_t>(count);
  return make_slots(std::vector<int>(n, 6), std::vector<double>(n, 1.0));
}

}  // namespace

BalanceMatrix::BalanceMatrix(const ConeProgram& program)
    : program_(program), slots_(rigid_slots(program.slots)), elimination_(slots_) {
  std::map<std::pair<int, int>, int> places;
  for (const ConeContact& c : program_.contacts)
    if (c.a >= 0 && c.b >= 0) places.emplace(std::minmax(c.a, c.b), 0);
  for (auto& [pair, place] : places) {
    place = static_cast<int>(std::ssize(system_.pairs));
    system_.pairs.push_back(pair);
  }
  for (const ConeContact& c : program_.contacts)
    pair_of_contact_.push_back(c.a >= 0 && c.b >= 0 ? places.at(std::minmax(c.a, c.b)) : -1);
  system_.diagonal.resize(index(program_.slots), 6);
  system_.off_diagonal.resize(system_.pairs.size(), 6);
}

VectorXd BalanceMatrix::loads(const VectorXd& forces) const {
  VectorXd sum = VectorXd::Zero(6 * program_.slots);
  for (Eigen::Index i = 0; i < std::ssize(program_.contacts); ++i) {
    const ConeContact& c = program_.contacts[static_cast<std::size_t>(i)];
    if (c.a >= 0) sum.segment<6>(6 * c.a) += c.map_a * forces.segment<3>(3 * i);
    if (c.b >= 0) sum.segment<6>(6 * c.b) += c.map_b * forces.segment<3>(3 * i);
  }
  return sum;
}

VectorXd BalanceMatrix::motions(const VectorXd& y) const {
  VectorXd result = VectorXd::Zero(3 * std::ssize(program_.contacts));
  for (Eigen::Index i = 0; i < std::ssize(program_.contacts); ++i) {
    const ConeContact& c = program_.contacts[static_cast<std::size_t>(i)];
    if (c.a >= 0) result.segment<3>(3 * i) += c.map_a.transpose() * y.segment<6>(6 * c.a);
    if (c.b >= 0) result.segment<3>(3 * i) += c.map_b.transpose() * y.segment<6>(6 * c.b);
  }
  return result;
}

bool BalanceMatrix::factorize(std::span<const Matrix3> weights, double proximal) {
  system_.diagonal.set_zero();
  system_.off_diagonal.set_zero();
  for (int slot = 0; slot < program_.slots; ++slot)
    system_.diagonal[index(slot)].diagonal().array() += proximal;
  for (std::size_t i = 0; i < program_.contacts.size(); ++i) {
    const ConeContact& c = program_.contacts[i];
    const Matrix6x3 by_a = c.map_a * weights[i], by_b = c.map_b * weights[i];
    if (c.a >= 0) system_.diagonal[index(c.a)] += by_a * c.map_a.transpose();
    if (c.b >= 0) system_.diagonal[index(c.b)] += by_b * c.map_b.transpose();
    if (pair_of_contact_[i] < 0) continue;
    system_.off_diagonal[index(pair_of_contact_[i])] +=
        c.a < c.b ? by_a * c.map_b.transpose() : by_b * c.map_a.transpose();
  }
  return elimination_.factorize(system_);
}

VectorXd BalanceMatrix::solve(const VectorXd& right) {
  BlockVector load(index(program_.slots), Vector12::Zero()), solution = load;
  for (int slot = 0; slot < program_.slots; ++slot)
    load[index(slot)].head<6>() = right.segment<6>(6 * slot);
  elimination_.solve(load, solution);
  VectorXd result(right.size());
  for (int slot = 0; slot < program_.slots; ++slot)
    result.segment<6>(6 * slot) = solution[index(slot)].head<6>();
  return result;
}

}  // namespace quoin::solver
