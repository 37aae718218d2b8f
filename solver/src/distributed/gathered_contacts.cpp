#include "distributed/gathered_contacts.hpp"

#include <algorithm>

#include "base/index.hpp"

namespace quoin::solver {
namespace {

struct ContactColumns {
  Matrix3x6 of_a, of_b;
};

Matrix3x6 strain(const ContactJacobian& jacobian) {
  return jacobian.strain ? *jacobian.strain : Matrix3x6(Matrix3x6::Zero());
}

}  // namespace

std::vector<LinearContact> gather(const Agreement& agreement, const Slots& slots,
                                  std::span<const LinearContact> contacts) {
  std::vector<ContactTerms> terms;
  std::vector<ContactColumns> rigid, strained;
  for (const LinearContact& c : contacts) {
    if (!agreement.counts(slots, c.slot_a, c.slot_b)) continue;
    terms.push_back(c);
    rigid.push_back({c.jacobian_a.rigid, c.jacobian_b.rigid});
    if (!slots.rigid()) strained.push_back({strain(c.jacobian_a), strain(c.jacobian_b)});
  }
  terms = agreement.of_all(terms);
  rigid = agreement.of_all(rigid);
  strained = agreement.of_all(strained);
  std::vector<LinearContact> all(terms.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    static_cast<ContactTerms&>(all[i]) = terms[i];
    all[i].jacobian_a.rigid = rigid[i].of_a;
    all[i].jacobian_b.rigid = rigid[i].of_b;
    if (strained.empty()) continue;
    all[i].jacobian_a.strain.make() = strained[i].of_a;
    all[i].jacobian_b.strain.make() = strained[i].of_b;
  }
  std::ranges::sort(all, {}, &LinearContact::number);
  return all;
}

std::vector<std::pair<int, int>> gather(const Agreement& agreement, const Slots& slots,
                                        std::span<const std::pair<int, int>> pairs) {
  std::vector<std::pair<int, int>> all;
  for (const auto& [a, b] : pairs) {
    if (agreement.counts(slots, a, b)) all.emplace_back(a, b);
  }
  all = agreement.of_all(all);
  std::ranges::sort(all);
  return all;
}

void take_back(std::span<const LinearContact> all, std::span<LinearContact> contacts) {
  for (LinearContact& c : contacts) {
    const auto of_all = std::ranges::lower_bound(all, c.number, {}, &LinearContact::number);
    const int pair = c.pair;
    static_cast<ContactTerms&>(c) = *of_all;
    c.pair = pair;
  }
}

}  // namespace quoin::solver
