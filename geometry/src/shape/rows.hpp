#pragma once
/// Lists of values, one for each of a count of things, in one array. Internal.

#include <cstddef>
#include <span>
#include <vector>

namespace quoin::geometry {

/// Sorts values into rows by counting. `visit(put)` calls `put(row, value)` for each, twice alike;
/// a row keeps their order. Row i: values[start[i]] … values[start[i + 1] - 1].
template <typename Visit, typename Value>
void fill_rows(int count, const Visit& visit, std::vector<int>& start, std::vector<Value>& values) {
  // Two places on, a count becomes the row's start, and then, one place on, its end.
  start.assign(static_cast<std::size_t>(count) + 2, 0);
  visit([&](int row, const Value&) { ++start[static_cast<std::size_t>(row) + 2]; });
  for (std::size_t i = 2; i < start.size(); ++i) start[i] += start[i - 1];
  values.resize(static_cast<std::size_t>(start.back()));
  visit([&](int row, const Value& value) {
    values[static_cast<std::size_t>(start[static_cast<std::size_t>(row) + 1]++)] = value;
  });
  start.pop_back();
}

struct IndexRows {
  std::vector<int> start, values;

  int size() const { return static_cast<int>(start.size()) - 1; }
  std::span<const int> operator[](int i) const {
    const std::size_t row = static_cast<std::size_t>(i);
    return {values.data() + start[row], values.data() + start[row + 1]};
  }
  std::span<int> operator[](int i) {
    const std::size_t row = static_cast<std::size_t>(i);
    return {values.data() + start[row], values.data() + start[row + 1]};
  }
};

template <typename Visit>
IndexRows rows_by(int count, const Visit& visit) {
  IndexRows rows;
  fill_rows(count, visit, rows.start, rows.values);
  return rows;
}

/// Polygons, one a row.
template <typename Polygons>
IndexRows rows_of(const Polygons& polygons) {
  IndexRows rows;
  std::size_t count = 0;
  for (const auto& polygon : polygons) count += polygon.size();
  rows.values.reserve(count);
  rows.start.reserve(polygons.size() + 1);
  rows.start.push_back(0);
  for (const auto& polygon : polygons) {
    rows.values.insert(rows.values.end(), polygon.begin(), polygon.end());
    rows.start.push_back(static_cast<int>(rows.values.size()));
  }
  return rows;
}

}  // namespace quoin::geometry
