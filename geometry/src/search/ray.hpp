#pragma once
/// Internal.

#include <quoin/geometry/queries.hpp>

namespace quoin::geometry {

/// Throws InputError for a ray that is none, as first_hit() does.
void require_ray(const Ray& ray);

}  // namespace quoin::geometry
