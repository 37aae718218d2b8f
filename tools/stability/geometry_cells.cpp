/// Shape, size and place.

#include <cmath>

#include "stability/cell.hpp"

namespace quoin::stability {
namespace {

/// A slide over about ten block sizes in 200 steps.
Slide scaled_slide(double size, double young) {
  Slide slide;
  slide.size = Vector3::Constant(size);
  slide.time_step = slide.rest_step = 0.01 * std::sqrt(size);
  slide.young = young;
  if (young > 0.0) slide.friction = 0.0;  // with friction the elastic sway has no closed form
  return slide;
}

void append_aspect_cells(std::vector<Cell>& cells) {
  for (int exponent = -4; exponent <= 4; ++exponent) {
    const double aspect = decade(exponent);
    cells.push_back({"rigid slide", {{"height_to_width", aspect}}, 1e-8, [=] {
                       Slide slide;  // higher ones lie along the slope
                       slide.size = aspect <= 1 ? Vector3(1, 1, aspect) : Vector3(aspect, 1, 1);
                       return run_slide(slide);
                     }});
    cells.push_back({"deformable slide", {{"height_to_width", aspect}}, 1e-6, [=] {
                       Slide slide;
                       slide.size = aspect <= 1 ? Vector3(1, 1, aspect) : Vector3(aspect, 1, 1);
                       slide.young = 1e10;
                       slide.friction = 0.0;
                       return run_slide(slide);
                     }});
    cells.push_back({"stack of 5", {{"height_to_width", aspect}}, 1e-6, [=] {
                       Stack stack;
                       stack.densities.assign(5, 2600);
                       stack.size =
                           aspect <= 1 ? Vector3(1, 1, aspect) : Vector3(1 / aspect, 1 / aspect, 1);
                       return run_stack(stack);
                     }});
  }
}

void append_size_cells(std::vector<Cell>& cells) {
  for (int exponent = -6; exponent <= 4; ++exponent) {
    const double size = decade(exponent);
    cells.push_back({"rigid slide", {{"size", size}}, 1e-8, [=] {
                       return run_slide(scaled_slide(size, 0.0));
                     }});
    cells.push_back({"deformable slide", {{"size", size}}, 1e-6, [=] {
                       return run_slide(scaled_slide(size, 1e10));
                     }});
    cells.push_back({"stack of 5", {{"size", size}}, 1e-6, [=] {
                       Stack stack;
                       stack.densities.assign(5, 2600);
                       stack.size = Vector3::Constant(size);
                       stack.time_step = 0.01 * std::sqrt(size);
                       return run_stack(stack);
                     }});
  }
}

void append_place_cells(std::vector<Cell>& cells) {
  for (int exponent = -1; exponent <= 8; ++exponent) {
    const double far = exponent < 0 ? 0.0 : decade(exponent);
    const Vector3 origin(far, -far, 0.5 * far);
    cells.push_back({"rigid slide", {{"coordinate", far}}, 1e-6, [=] {
                       Slide slide;
                       slide.origin = origin;
                       return run_slide(slide);
                     }});
    cells.push_back({"deformable slide", {{"coordinate", far}}, 1e-6, [=] {
                       Slide slide;
                       slide.young = 5e9;
                       slide.friction = 0.0;
                       slide.origin = origin;
                       return run_slide(slide);
                     }});
    cells.push_back({"stack of 5", {{"coordinate", far}}, 1e-6, [=] {
                       Stack stack;
                       stack.densities.assign(5, 2600);
                       stack.origin = origin;
                       return run_stack(stack);
                     }});
  }
}

}  // namespace

void append_geometry_cells(std::vector<Cell>& cells) {
  append_aspect_cells(cells);
  append_size_cells(cells);
  append_place_cells(cells);
}

}  // namespace quoin::stability
