#pragma once
/// All of quoin::geometry.

#include <quoin/geometry/body.hpp>
#include <quoin/geometry/broad_phase.hpp>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/contact_finder.hpp>
#include <quoin/geometry/contact_point.hpp>
#include <quoin/geometry/contact_type.hpp>
#include <quoin/geometry/executor.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/geometry/nearest_features.hpp>
#include <quoin/geometry/pair_batch.hpp>
#include <quoin/geometry/published_search.hpp>
#include <quoin/geometry/queries.hpp>
#include <quoin/geometry/shape.hpp>
#include <quoin/geometry/split.hpp>
#include <quoin/geometry/time_of_impact.hpp>
#include <quoin/geometry/types.hpp>
#include <quoin/geometry/worker_pool.hpp>
