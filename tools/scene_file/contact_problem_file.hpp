#pragma once
/// Contact problems as text: the format is in solver/README.md, "Contact problems".

#include <iosfwd>
#include <quoin/solver/contact_problem.hpp>

namespace quoin::scene_file {

/// Numbers are read back to the bit.
void write(std::ostream& out, const solver::ContactProblem& problem);

/// Throws InputError naming what is wrong, and where; what the numbers say is checked where the
/// problem is solved.
solver::ContactProblem read_contact_problem(std::istream& in);

}  // namespace quoin::scene_file
