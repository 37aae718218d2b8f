#include "statics/cone_program.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/index.hpp"
#include "iteration/cone.hpp"

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
  for (Eigen::Index i = 0; i < std::ssize(program_.contacts); ++i)
    program_.contacts[static_cast<std::size_t>(i)].add_load(forces.segment<3>(3 * i), sum);
  return sum;
}

VectorXd BalanceMatrix::motions(const VectorXd& y) const {
  VectorXd result(3 * std::ssize(program_.contacts));
  for (Eigen::Index i = 0; i < std::ssize(program_.contacts); ++i)
    result.segment<3>(3 * i) = program_.contacts[static_cast<std::size_t>(i)].motion(y);
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

namespace {

constexpr double kProximal = 1e-8;      // of forces and blocks of size 1: smaller loses pivots
constexpr double kHeldProximal = 1e-4;  // of held points, which no cone's weight softens
constexpr double kSolved = 1e-9;        // residuals, by tau
constexpr double kCertificate = 1e-9;   // residual of a mechanism, by its power and its speed
constexpr double kOfSum = 0.1;          // likewise of the residuals' sum
constexpr double kNoMechanism = 1e-6;   // kappa by tau, and residuals, where forces seem to exist
constexpr double kRefined = 1e-2;       // of a right-hand side: directions that are worse end it
constexpr double kToRim = 0.99;         // of the longest step
constexpr double kExact = 1e-13;        // likewise: no better is sought
constexpr double kRefinedEnough = 0.5;  // of an error by another refinement: none is gained
constexpr int kRefinements = 3;

/// One cone of K: three rows (second order) or one (not negative).
struct Cone {
  int contact = -1;  ///< -1: lambda
  int row = 0;       ///< first, in s and z
  bool round = false;
  double sign = -1.0;  ///< of lambda's row of G
};

/// A direction, or a right-hand side, of x (with lambda), y and z.
struct Triple {
  VectorXd x, y, z;
  double size() const { return std::max({largest_entry(x), largest_entry(y), largest_entry(z)}); }
  void add(double factor, const Triple& more) {
    x += factor * more.x;
    y += factor * more.y;
    z += factor * more.z;
  }
};

class SelfDualMethod {
 public:
  explicit SelfDualMethod(const ConeProgram& program);
  ConeSolution solve(int most);

 private:
  struct Residuals : Triple {
    double t = 0.0;
  };
  struct Step {
    Triple d;
    VectorXd s;
    double tau = 0.0, kappa = 0.0;
  };
  enum class End { Going, Solved, Mechanism };

  bool with_factor() const { return program_.live.size() > 0; }
  Eigen::Index lambda() const { return 3 * std::ssize(program_.contacts); }
  void add_cones();
  VectorXd loads(const VectorXd& x) const;    ///< A x + lambda a
  VectorXd motions(const VectorXd& y) const;  ///< (A'y | a'y)
  VectorXd rows(const VectorXd& x) const;     ///< G x
  VectorXd columns(const VectorXd& z) const;  ///< G'z
  /// `of` a cone's scaling and its rows of vectors like s and z: three of them or one.
  template <class Operation, class... Vectors>
  VectorXd by_cone(const Operation& of, const Vectors&... vectors) const;
  VectorXd apply(const VectorXd& v, double sign) const;        ///< W v, W⁻¹ v
  VectorXd apply_twice(const VectorXd& v, double sign) const;  ///< W W v, W⁻¹ W⁻¹ v
  VectorXd divided(const VectorXd& l, const VectorXd& r) const;
  VectorXd multiplied(const VectorXd& u, const VectorXd& v) const;
  double longest_step(const VectorXd& v, const VectorXd& d) const;
  void set_scalings();
  Matrix3 inverse(std::size_t contact) const;
  double factor_weight() const;  ///< D of lambda
  bool factorize();
  VectorXd solve_balance(const VectorXd& right);  ///< S⁻¹, bordered by lambda
  VectorXd forward(const VectorXd& q) const;      ///< D⁻¹ q
  Triple direct(const Triple& right);
  Triple leftover(const Triple& right, const Triple& d) const;
  bool refined(const Triple& right, Triple& d);
  Residuals residuals() const;
  End judge(const Residuals& r);
  bool iterate(const Residuals& r);
  Step step(const Residuals& r, const Triple& d2, double sigma, const VectorXd& centre,
            double centre_tau);
  double length(const Step& step) const;
  double unbalance(const VectorXd& x) const { return largest_entry(loads(x) - b_); }
  bool inside(const VectorXd& x) const;
  void polish();

  const ConeProgram& program_;
  BalanceMatrix matrix_;
  std::vector<Cone> cones_;
  std::vector<int> round_of_, row_of_;  ///< by contact: cone, -1: none
  VectorXd b_, c_, h_, e_, proximal_;   ///< the last: of x
  VectorXd x_, y_, s_, z_, best_x_, best_y_, mechanism_y_;
  double tau_ = 1.0, kappa_ = 1.0, best_ = kInfinite, least_wrong_ = kInfinite;
  std::vector<ConeScaling> scalings_;  ///< of a single row `w[0]` alone counts
  VectorXd l_;
  std::vector<Matrix3> inverse_;  ///< D⁻¹
  double inverse_factor_ = 0.0;   ///< D⁻¹ of lambda
  VectorXd border_;               ///< S⁻¹ a
  int factorizations_ = 0;
};

SelfDualMethod::SelfDualMethod(const ConeProgram& program) : program_(program), matrix_(program) {
  add_cones();
  b_ = -program.load;
  x_ = c_ = VectorXd::Zero(lambda() + (with_factor() ? 1 : 0));
  y_ = VectorXd::Zero(6 * program.slots);
  if (with_factor())
    c_[lambda()] = -1.0;
  else
    for (std::size_t i = 0; i < program.contacts.size(); ++i)
      c_[3 * static_cast<Eigen::Index>(i)] = program.contacts[i].cost;
  proximal_ = VectorXd::Constant(x_.size(), kProximal);
  for (std::size_t i = 0; i < program.contacts.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    if (program.contacts[i].held) proximal_.segment<3>(at).setConstant(kHeldProximal);
  }
  s_ = z_ = e_;
  scalings_.resize(cones_.size());
  inverse_.resize(program.contacts.size());
}

void SelfDualMethod::add_cones() {
  int row = 0;
  round_of_.assign(program_.contacts.size(), -1);
  row_of_ = round_of_;
  std::vector<double> bounds, units;
  const auto add = [&](int contact, bool round, double sign, double bound) {
    cones_.push_back({contact, row, round, sign});
    bounds.push_back(bound);
    units.push_back(1.0);
    bounds.resize(bounds.size() + (round ? 2 : 0), 0.0);
    units.resize(bounds.size(), 0.0);
    row += round ? 3 : 1;
    return static_cast<int>(std::ssize(cones_)) - 1;
  };
  for (std::size_t i = 0; i < program_.contacts.size(); ++i) {
    const ConeContact& contact = program_.contacts[i];
    const int number = static_cast<int>(i);
    if (contact.has_cone()) round_of_[i] = add(number, true, -1.0, contact.cohesion);
    if (contact.has_cut_off()) row_of_[i] = add(number, false, -1.0, contact.tension);
  }
  if (with_factor()) {
    add(-1, false, -1.0, 0.0);
    add(-1, false, 1.0, 1.0);
  }
  h_ = Eigen::Map<VectorXd>(bounds.data(), row);
  e_ = Eigen::Map<VectorXd>(units.data(), row);
}

VectorXd SelfDualMethod::loads(const VectorXd& x) const {
  VectorXd sum = matrix_.loads(x);
  if (with_factor()) sum += x[lambda()] * program_.live;
  return sum;
}

VectorXd SelfDualMethod::motions(const VectorXd& y) const {
  VectorXd result = matrix_.motions(y);
  if (!with_factor()) return result;
  result.conservativeResize(x_.size());
  result[lambda()] = program_.live.dot(y);
  return result;
}

VectorXd SelfDualMethod::rows(const VectorXd& x) const {
  VectorXd result(h_.size());
  for (const Cone& cone : cones_) {
    if (cone.contact < 0) {
      result[cone.row] = cone.sign * x[lambda()];
    } else if (!cone.round) {
      result[cone.row] = -x[3 * cone.contact];
    } else {
      const ConeContact& c = program_.contacts[index(cone.contact)];
      result[cone.row] = -c.friction * x[3 * cone.contact];
      result.segment<2>(cone.row + 1) = -x.segment<2>(3 * cone.contact + 1);
    }
  }
  return result;
}

VectorXd SelfDualMethod::columns(const VectorXd& z) const {
  VectorXd result = VectorXd::Zero(x_.size());
  for (const Cone& cone : cones_) {
    if (cone.contact < 0) {
      result[lambda()] += cone.sign * z[cone.row];
    } else if (!cone.round) {
      result[3 * cone.contact] -= z[cone.row];
    } else {
      const ConeContact& c = program_.contacts[index(cone.contact)];
      result[3 * cone.contact] -= c.friction * z[cone.row];
      result.segment<2>(3 * cone.contact + 1) -= z.segment<2>(cone.row + 1);
    }
  }
  return result;
}

template <class Operation, class... Vectors>
VectorXd SelfDualMethod::by_cone(const Operation& of, const Vectors&... vectors) const {
  VectorXd result(h_.size());
  for (std::size_t k = 0; k < cones_.size(); ++k) {
    const int row = cones_[k].row;
    if (cones_[k].round)
      result.segment<3>(row) = of(scalings_[k], Vector3(vectors.template segment<3>(row))...);
    else
      result[row] = of(scalings_[k], vectors[row]...);
  }
  return result;
}

VectorXd SelfDualMethod::apply(const VectorXd& v, double sign) const {
  return by_cone([&](const auto& w, const auto& part) { return scaled(w, part, sign); }, v);
}

VectorXd SelfDualMethod::apply_twice(const VectorXd& v, double sign) const {
  return by_cone([&](const auto& w, const auto& part) { return scaled_twice(w, part, sign); }, v);
}

VectorXd SelfDualMethod::divided(const VectorXd& l, const VectorXd& r) const {
  return by_cone([](auto&, const auto& of_l, const auto& of_r) { return quotient(of_l, of_r); }, l,
                 r);
}

VectorXd SelfDualMethod::multiplied(const VectorXd& u, const VectorXd& v) const {
  return by_cone([](auto&, const auto& of_u, const auto& of_v) { return product(of_u, of_v); }, u,
                 v);
}

double SelfDualMethod::longest_step(const VectorXd& v, const VectorXd& d) const {
  double alpha = kInfinite;
  for (const Cone& cone : cones_) {
    const int row = cone.row;
    alpha = std::min(alpha, cone.round ? longest(Vector3(v.segment<3>(row)), d.segment<3>(row))
                                       : longest(v[row], d[row]));
  }
  return alpha;
}

void SelfDualMethod::set_scalings() {
  for (std::size_t k = 0; k < cones_.size(); ++k) {
    const int row = cones_[k].row;
    if (cones_[k].round)
      scalings_[k] = cone_scaling(s_.segment<3>(row), z_.segment<3>(row));
    else
      scalings_[k].w[0] = std::sqrt(s_[row] / z_[row]);
  }
  l_ = apply(z_, 1.0);
}

/// D⁻¹ = (delta + G'W⁻²G)⁻¹ of a contact. With U = G⁻¹W it is U (I + U'M U)⁻¹ U', which loses no
/// digits where the force is at the rim, unless its cut-off weighs more there.
Matrix3 SelfDualMethod::inverse(std::size_t contact) const {
  const ConeContact& c = program_.contacts[contact];
  Matrix3 rest = (c.held ? kHeldProximal : kProximal) * Matrix3::Identity();
  if (const int k = row_of_[contact]; k >= 0)
    rest(0, 0) += z_[cones_[index(k)].row] / s_[cones_[index(k)].row];
  const int round = round_of_[contact];
  if (round < 0) {
    Matrix3 result = Matrix3::Zero();
    result(0, 0) = 1.0 / rest(0, 0);
    return c.held ? Matrix3(rest.inverse()) : result;
  }
  const double eta = scalings_[index(round)].eta;
  const bool cut_off = row_of_[contact] >= 0 && rest(0, 0) * eta * eta > 1.0;
  if (c.friction > 0.0 && !cut_off) {
    const Matrix3 w = matrix(scalings_[index(round)], 1.0);
    const Matrix3 u = Vector3(1.0 / c.friction, 1.0, 1.0).asDiagonal() * w;
    const Matrix3 inner = Matrix3::Identity() + u.transpose() * rest * u;
    return u * inner.inverse() * u.transpose();
  }
  const Matrix3 unscaled = matrix(scalings_[index(round)], -1.0);
  const Matrix3 g = Vector3(c.friction, 1.0, 1.0).asDiagonal();
  rest += g * unscaled * unscaled * g;
  return rest.inverse();
}

double SelfDualMethod::factor_weight() const {
  double diagonal = kProximal;
  for (const Cone& cone : cones_)
    if (cone.contact < 0) diagonal += z_[cone.row] / s_[cone.row];
  return diagonal;
}

bool SelfDualMethod::factorize() {
  for (std::size_t i = 0; i < inverse_.size(); ++i) inverse_[i] = inverse(i);
  ++factorizations_;
  if (!matrix_.factorize(inverse_, kProximal)) return false;
  if (!with_factor()) return true;
  inverse_factor_ = 0.0;
  border_ = solve_balance(program_.live);
  inverse_factor_ = 1.0 / (factor_weight() + program_.live.dot(border_));
  return border_.allFinite();
}

VectorXd SelfDualMethod::solve_balance(const VectorXd& right) {
  VectorXd result = matrix_.solve(right);
  if (inverse_factor_ > 0.0) result -= inverse_factor_ * program_.live.dot(result) * border_;
  return result;
}

VectorXd SelfDualMethod::forward(const VectorXd& q) const {
  VectorXd result(q.size());
  for (std::size_t i = 0; i < inverse_.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    result.segment<3>(at) = inverse_[i] * q.segment<3>(at);
  }
  if (!with_factor()) return result;
  result[lambda()] = q[lambda()] / factor_weight();
  return result;
}

/// Solves [delta A' G'; A -delta 0; G 0 -W²] d = right.
Triple SelfDualMethod::direct(const Triple& right) {
  const auto unweighted = [&](const VectorXd& v) { return apply_twice(v, -1.0); };
  const VectorXd q = right.x + columns(unweighted(right.z));
  Triple d;
  d.y = solve_balance(loads(forward(q)) - right.y);
  const VectorXd moved = motions(d.y);
  d.x = forward(q - moved);
  d.z = unweighted(rows(d.x) - right.z);
  // W⁻² loses digits where W is small: there the first row has z.
  const VectorXd left = right.x - proximal_.cwiseProduct(d.x) - moved;
  for (std::size_t k = 0; k < cones_.size(); ++k) {
    const Cone& cone = cones_[k];
    if (!cone.round || row_of_[index(cone.contact)] >= 0 || !(scalings_[k].eta < 1.0)) continue;
    const Vector3 g(program_.contacts[index(cone.contact)].friction, 1.0, 1.0);
    d.z.segment<3>(cone.row) = -left.segment<3>(3 * cone.contact).cwiseQuotient(g);
  }
  return d;
}

Triple SelfDualMethod::leftover(const Triple& right, const Triple& d) const {
  return {right.x - proximal_.cwiseProduct(d.x) - motions(d.y) - columns(d.z),
          right.y - loads(d.x) + kProximal * d.y, right.z - rows(d.x) + apply_twice(d.z, 1.0)};
}

bool SelfDualMethod::refined(const Triple& right, Triple& d) {
  d = direct(right);
  const double size = right.size();
  Triple left = leftover(right, d);
  double error = left.size();
  for (int i = 0; i < kRefinements && error > kExact * size; ++i) {
    Triple better = d;
    better.add(1.0, direct(left));
    left = leftover(right, better);
    const double before = error;
    if (!(left.size() < before)) break;
    error = left.size();
    d = std::move(better);
    if (error > kRefinedEnough * before) break;
  }
  return error <= kRefined * size;
}

SelfDualMethod::Residuals SelfDualMethod::residuals() const {
  return {{motions(y_) + columns(z_) + tau_ * c_, loads(x_) - tau_ * b_, rows(x_) + s_ - tau_ * h_},
          kappa_ + c_.dot(x_) + b_.dot(y_) + h_.dot(z_)};
}

SelfDualMethod::End SelfDualMethod::judge(const Residuals& r) {
  const double power = -b_.dot(y_) - h_.dot(z_);
  const VectorXd lacks = r.x - tau_ * c_;
  const double wrong = std::max(kOfSum * lacks.lpNorm<1>(),
                                largest_entry(lacks) * std::max(1.0, power / largest_entry(y_)));
  if (kappa_ > tau_ && power > 0.0 && wrong < kCertificate * power) {
    best_y_ = y_;
    best_x_ = x_ / tau_;
    return End::Mechanism;
  }
  if (kappa_ > tau_ && power > 0.0 && wrong < least_wrong_ * power) {
    least_wrong_ = wrong / power;
    mechanism_y_ = y_;
  }
  const double objective = std::max(1.0, std::abs(c_.dot(x_)) / tau_);
  const double gap = s_.dot(z_) / (tau_ * tau_ * objective);
  const double worst = r.size() / tau_;
  if (const double merit = std::max(worst, gap); merit < best_ || best_x_.size() == 0) {
    best_ = merit;
    best_x_ = x_ / tau_;
    best_y_ = y_ / tau_;
  }
  const bool seems =
      program_.mechanism_only && worst < kNoMechanism && kappa_ < kNoMechanism * tau_;
  return best_ < kSolved || seems ? End::Solved : End::Going;
}

SelfDualMethod::Step SelfDualMethod::step(const Residuals& r, const Triple& d2, double sigma,
                                          const VectorXd& centre, double centre_tau) {
  const double left = 1.0 - sigma;
  Step step;
  const Triple right{-left * r.x, -left * r.y, -left * r.z - apply(divided(l_, centre), 1.0)};
  if (!refined(right, step.d)) step.tau = std::numeric_limits<double>::quiet_NaN();
  const auto along = [&](const Triple& d) { return c_.dot(d.x) + b_.dot(d.y) + h_.dot(d.z); };
  const double top = left * r.t + centre_tau / tau_ + along(step.d);
  step.tau += -top / (-kappa_ / tau_ + along(d2));
  step.kappa = (centre_tau - kappa_ * step.tau) / tau_;
  step.d.add(step.tau, d2);
  step.s = -left * r.z + step.tau * h_ - rows(step.d.x);
  return step;
}

double SelfDualMethod::length(const Step& step) const {
  return std::min({longest_step(s_, step.s), longest_step(z_, step.d.z), longest(tau_, step.tau),
                   longest(kappa_, step.kappa)});
}

bool SelfDualMethod::iterate(const Residuals& r) {
  set_scalings();
  if (!factorize()) return false;
  Triple d2;
  if (!refined({-c_, b_, h_}, d2)) return false;
  const double mean = (s_.dot(z_) + tau_ * kappa_) / static_cast<double>(std::ssize(cones_) + 1);
  const VectorXd square = multiplied(l_, l_);
  const Step guess = step(r, d2, 0.0, -square, -tau_ * kappa_);
  if (!std::isfinite(guess.tau)) return false;
  const double reached = std::min(1.0, length(guess));
  const double sigma = std::pow(1.0 - reached, 3);
  const VectorXd second = multiplied(apply(guess.s, -1.0), apply(guess.d.z, 1.0));
  const Step taken = step(r, d2, sigma, -square - second + sigma * mean * e_,
                          -tau_ * kappa_ - guess.tau * guess.kappa + sigma * mean);
  const double alpha = std::min(1.0, kToRim * length(taken));
  if (!std::isfinite(taken.tau) || !(alpha > 1e-10)) return false;
  x_ += alpha * taken.d.x;
  y_ += alpha * taken.d.y;
  z_ += alpha * taken.d.z;
  s_ += alpha * taken.s;
  tau_ += alpha * taken.tau;
  kappa_ += alpha * taken.kappa;
  return true;
}

bool SelfDualMethod::inside(const VectorXd& x) const {
  const VectorXd s = h_ - rows(x);
  return std::ranges::all_of(cones_, [&](const Cone& cone) {
    return s[cone.row] >= (cone.round ? s.segment<2>(cone.row + 1).norm() : 0.0);
  });
}

/// Takes what is left of the balance off the forces, by the last factors.
void SelfDualMethod::polish() {
  inverse_factor_ = 0.0;  // lambda stays
  for (int i = 0; i < kRefinements; ++i) {
    VectorXd change = forward(motions(solve_balance(loads(best_x_) - b_)));
    if (with_factor()) change[lambda()] = 0.0;
    const VectorXd better = best_x_ - change;
    if (!(unbalance(better) < unbalance(best_x_)) || (inside(best_x_) && !inside(better))) return;
    best_x_ = better;
  }
}

ConeSolution SelfDualMethod::solve(int most) {
  End end = End::Going;
  for (int i = 0; i <= most; ++i) {
    const Residuals r = residuals();
    end = judge(r);
    if (end != End::Going || i == most || !iterate(r)) break;
  }
  if (end != End::Mechanism && factorizations_ > 0) polish();
  // It may open contacts by more than its residual.
  if (end == End::Going && kappa_ > tau_ && least_wrong_ < kInfinite) best_y_ = mechanism_y_;
  ConeSolution solution{best_x_.head(lambda()), best_y_, 0.0, factorizations_};
  if (with_factor()) solution.factor = best_x_[lambda()];
  return solution;
}

}  // namespace

ConeSolution solve(const ConeProgram& program, int most_iterations) {
  return SelfDualMethod(program).solve(most_iterations);
}

namespace {

constexpr int kMotionRounds = 4;           // Newton: directions of slip change little
constexpr int kMotionRefinements = 4;      // of a solve with the proximal term
constexpr double kMotionProximal = 1e-10;  // of motions of size 1: redundant conditions
constexpr double kNoSlip = 1e-14;          // of a direction

/// What a contact's motion has to lose: `weight` projects on it.
struct Excess {
  Matrix3 weight = Matrix3::Zero();
  Vector3 motion = Vector3::Zero();
};

Excess excess(const ConeContact& contact, const Vector3& v, double near) {
  if (contact.held || v.norm() < near) return {Matrix3::Identity(), v};
  const double slip = contact.has_cone() ? v.tail<2>().norm() : 0.0;
  if (!(v[0] - contact.friction * slip < near)) return {};
  Vector3 along = Vector3::UnitX();
  if (slip > kNoSlip) along.tail<2>() = -contact.friction / slip * v.tail<2>();
  along.normalize();
  return {along * along.transpose(), along * along.dot(v)};
}

}  // namespace

VectorXd compatible_motion(const ConeProgram& program, VectorXd y, double near) {
  BalanceMatrix matrix(program);
  std::vector<Matrix3> weights(program.contacts.size());
  for (int round = 0; round < kMotionRounds; ++round) {
    const VectorXd motions = matrix.motions(y);
    VectorXd left = VectorXd::Zero(motions.size());
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const auto at = 3 * static_cast<Eigen::Index>(i);
      const Excess over = excess(program.contacts[i], motions.segment<3>(at), near);
      weights[i] = over.weight;
      left.segment<3>(at) = over.motion;
    }
    if (!matrix.factorize(weights, kMotionProximal)) break;
    for (int i = 0; i < kMotionRefinements; ++i) {
      const VectorXd change = matrix.solve(matrix.loads(left));
      if (!change.allFinite()) return y;
      y -= change;
      const VectorXd moved = matrix.motions(change);
      for (std::size_t k = 0; k < weights.size(); ++k) {
        const auto at = 3 * static_cast<Eigen::Index>(k);
        left.segment<3>(at) -= weights[k] * moved.segment<3>(at);
      }
    }
  }
  return y;
}

}  // namespace quoin::solver
