/// A foreign program that asks for one pair, N times (first argument). QUOIN_LEAN_GEOMETRY and
/// QUOIN_LEAN_SOLVER link more of quoin without running it: what bench/bench-lean compares.

#include <cstdio>
#include <cstdlib>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/contact_point.hpp>
#ifdef QUOIN_LEAN_GEOMETRY
#include <quoin/geometry.hpp>
#endif
#ifdef QUOIN_LEAN_SOLVER
#include <quoin/solver.hpp>
#endif

namespace geometry = quoin::geometry;

namespace {

double ask(int times) {
  const geometry::Shape a = geometry::make_box({0, 0, 0}, {2, 1, 1});  // m
  const geometry::Shape b = geometry::make_box({1, 0, 1.25}, {3, 1, 2});
  std::vector<geometry::ContactPoint> contacts;
  double sum = 0.0;
  for (int i = 0; i < times; ++i) {
    contacts.clear();
    const geometry::NearestFeatures nearest =
        append_contacts_within_reach({0, 1}, a, b, {.reach = 1.0}, {}, contacts);
    sum += nearest.gap * static_cast<double>(contacts.size());
  }
  return sum;
}

/// Never run, but linked.
void rest() {
#ifdef QUOIN_LEAN_GEOMETRY
  std::vector<geometry::ContactPoint> contacts;
  geometry::ContactFinder({.reach = 1e-3}).find(contacts);
#endif
#ifdef QUOIN_LEAN_SOLVER
  quoin::solver::Simulation simulation({}, {});
  if (simulation.advance().status == quoin::solver::StepStatus::Converged)
    quoin::solver::write_blocks("blocks.vtu", simulation);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  const int times = argc > 1 ? std::atoi(argv[1]) : 0;
  if (times < 0) rest();
  if (times > 0) std::printf("%g\n", ask(times));
  return 0;
}
