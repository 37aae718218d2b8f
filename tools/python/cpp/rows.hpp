#pragma once
/// Rows of the structured arrays that Python gets; the names of members are those of the fields.

#include <cstdint>
#include <quoin/geometry/pair_batch.hpp>

#include "arrays.hpp"

namespace quoin::python {

struct ContactRow {
  std::int32_t a, b;
  std::uint8_t type, kind_a, kind_b;
  bool indeterminate;
  std::int32_t feature_a, feature_b, previous;
  double point[3], point_a[3], point_b[3], normal[3], gap, area;
};

struct NearestRow {
  std::uint8_t status, rule, kind_a, kind_b;
  bool indeterminate;
  std::int32_t feature_a, feature_b, iterations;
  double gap, normal[3], point_a[3], point_b[3], residual_a, residual_b;
};

struct PairRow {
  std::int32_t a, b;
  std::uint8_t status, type, event;
  bool indeterminate;
  std::int32_t first, count;
  double gap, normal[3], area;
};

void register_rows();  ///< with numpy, once

py::array_t<ContactRow> rows(const std::vector<geometry::ContactPoint>& contacts);
py::array_t<NearestRow> rows(const std::vector<geometry::NearestFeatures>& answers);
py::array_t<PairRow> rows(std::span<const geometry::PairResult> pairs);

}  // namespace quoin::python
