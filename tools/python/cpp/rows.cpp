#include "rows.hpp"

namespace quoin::python {
namespace {

void set(double (&target)[3], const Vector3& v) {
  target[0] = v.x();
  target[1] = v.y();
  target[2] = v.z();
}

/// What nearest features and contact points have in common; `features`: whose both are.
template <class Row, class Record, class Features>
void set_common(Row& row, const Record& record, const Features& features) {
  row.kind_a = static_cast<std::uint8_t>(features.feature_a.kind);
  row.kind_b = static_cast<std::uint8_t>(features.feature_b.kind);
  row.feature_a = features.feature_a.index;
  row.feature_b = features.feature_b.index;
  row.indeterminate = record.indeterminate;
  row.gap = record.gap;
  set(row.normal, record.normal);
  set(row.point_a, record.point_a);
  set(row.point_b, record.point_b);
}

void set(ContactRow& row, const geometry::ContactPoint& c) {
  set_common(row, c, c.key);
  row.a = c.key.a;
  row.b = c.key.b;
  row.type = static_cast<std::uint8_t>(c.type);
  row.previous = c.previous;
  set(row.point, c.point());
  row.area = c.area;
}

void set(NearestRow& row, const geometry::NearestFeatures& n) {
  set_common(row, n, n);
  row.status = static_cast<std::uint8_t>(n.status);
  row.rule = static_cast<std::uint8_t>(n.rule);
  row.iterations = n.iterations;
  row.residual_a = n.residual_a;
  row.residual_b = n.residual_b;
}

void set(PairRow& row, const geometry::PairResult& p) {
  row.a = p.a;
  row.b = p.b;
  row.status = static_cast<std::uint8_t>(p.status);
  row.type = static_cast<std::uint8_t>(p.type);
  row.event = static_cast<std::uint8_t>(p.event);
  row.indeterminate = p.indeterminate;
  row.first = p.first;
  row.count = p.count;
  row.gap = p.gap;
  set(row.normal, p.normal);
  row.area = p.area;
}

template <class Row, class Records>
py::array_t<Row> array_of(const Records& records) {
  py::array_t<Row> result(static_cast<py::ssize_t>(records.size()));
  Row* row = result.mutable_data();
  for (const auto& record : records) set(*row++, record);
  return result;
}

}  // namespace

void register_rows() {
  PYBIND11_NUMPY_DTYPE(ContactRow, a, b, type, kind_a, kind_b, indeterminate, feature_a, feature_b,
                       previous, point, point_a, point_b, normal, gap, area);
  PYBIND11_NUMPY_DTYPE(NearestRow, status, rule, kind_a, kind_b, indeterminate, feature_a,
                       feature_b, iterations, gap, normal, point_a, point_b, residual_a,
                       residual_b);
  PYBIND11_NUMPY_DTYPE(PairRow, a, b, status, type, event, indeterminate, first, count, gap, normal,
                       area);
}

py::array_t<ContactRow> rows(const std::vector<geometry::ContactPoint>& contacts) {
  return array_of<ContactRow>(contacts);
}
py::array_t<NearestRow> rows(const std::vector<geometry::NearestFeatures>& answers) {
  return array_of<NearestRow>(answers);
}
py::array_t<PairRow> rows(std::span<const geometry::PairResult> pairs) {
  return array_of<PairRow>(pairs);
}

}  // namespace quoin::python
