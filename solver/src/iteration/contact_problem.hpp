#pragma once
/// A step's linearised contacts as a ContactProblem.

#include <quoin/solver/contact_problem.hpp>
#include <span>

#include "contact/contact_jacobian.hpp"
#include "linear/linear_solver.hpp"

namespace quoin::solver {

/// `base`: block terms; `guess`: of the increments; `contacts`: with their multipliers.
ContactProblem contact_problem(const Slots& slots, const BlockSystem& base,
                               const BlockVector& force, std::span<const LinearContact> contacts,
                               const BlockVector& guess);

}  // namespace quoin::solver
