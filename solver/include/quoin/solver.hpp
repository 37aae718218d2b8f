#pragma once
/// All of quoin::solver.

#include <quoin/solver/contact_problem.hpp>
#include <quoin/solver/equilibrium.hpp>
#include <quoin/solver/output.hpp>
#include <quoin/solver/scene.hpp>
#include <quoin/solver/simulation.hpp>
#include <quoin/solver/state.hpp>
