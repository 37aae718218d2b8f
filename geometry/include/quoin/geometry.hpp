#pragma once
/// All of quoin::geometry but the oracle (gjk_oracle.hpp, a target of its own).

#include <quoin/geometry/broad_phase.hpp>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/contact_finder.hpp>
#include <quoin/geometry/contact_point.hpp>
#include <quoin/geometry/contact_type.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/geometry/nearest_features.hpp>
#include <quoin/geometry/polyhedron.hpp>
#include <quoin/geometry/types.hpp>
