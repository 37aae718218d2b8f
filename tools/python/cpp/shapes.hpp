#pragma once
/// Shape and body as Python holds them.

#include <memory>
#include <quoin/geometry/body.hpp>

namespace quoin::python {

using ShapePointer = std::shared_ptr<geometry::Shape>;

/// A body that keeps its shape alive.
struct HeldBody {
  HeldBody(ShapePointer held, const geometry::Placement& placement)
      : shape(std::move(held)), body(*shape, placement) {}
  ShapePointer shape;
  geometry::Body body;
};

}  // namespace quoin::python
