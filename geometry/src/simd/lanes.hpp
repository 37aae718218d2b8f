#pragma once
/// Four numbers side by side, in plain code. See kernels/kernels.hpp. Internal.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace quoin::geometry {
namespace {

struct PlainLanes {
  double v[4];

  struct Flags {
    unsigned all;
    unsigned bits() const { return all; }
    Flags operator&(const Flags& b) const { return {all & b.all}; }
    Flags operator|(const Flags& b) const { return {all | b.all}; }
    Flags operator^(const Flags& b) const { return {all ^ b.all}; }
    Flags without(const Flags& b) const { return {all & ~b.all}; }
  };
  static Flags only(std::size_t lane) { return {1u << lane}; }

  /// Numbers of a row, by their places in it.
  static PlainLanes picked(const double* row, const std::uint16_t* place) {
    return each([=](int k) { return row[place[k]]; });
  }
  /// Four of the rows of a table, turned: all their first numbers, all second ones, …
  static void turn(const double (*rows)[4], const std::uint16_t* row, PlainLanes (&turned)[4]) {
    for (int k = 0; k < 4; ++k) turned[k] = each([=](int i) { return rows[row[i]][k]; });
  }
  static PlainLanes of(double a, double b, double c, double d) { return {{a, b, c, d}}; }
  /// Four numbers on a 32-byte border.
  static PlainLanes of(const double* row) {
    return each([row](int k) { return row[k]; });
  }
  static PlainLanes all(double x) {
    return each([x](int) { return x; });
  }
  /// Four places of three coordinates as rows.
  static void turned(const double* const (&place)[4], PlainLanes& x, PlainLanes& y, PlainLanes& z) {
    for (int k = 0; k < 4; ++k) {
      x.v[k] = place[k][0];
      y.v[k] = place[k][1];
      z.v[k] = place[k][2];
    }
  }
  void store(double* row) const { std::copy(v, v + 4, row); }
  PlainLanes operator+(const PlainLanes& b) const {
    return each([&](int k) { return v[k] + b.v[k]; });
  }
  PlainLanes operator-(const PlainLanes& b) const {
    return each([&](int k) { return v[k] - b.v[k]; });
  }
  PlainLanes operator*(const PlainLanes& b) const {
    return each([&](int k) { return v[k] * b.v[k]; });
  }
  PlainLanes operator/(const PlainLanes& b) const {
    return each([&](int k) { return v[k] / b.v[k]; });
  }
  PlainLanes root() const {
    return each([&](int k) { return std::sqrt(v[k]); });
  }
  PlainLanes size() const {
    return each([&](int k) { return std::abs(v[k]); });
  }
  PlainLanes smaller(const PlainLanes& b) const {
    return each([&](int k) { return v[k] < b.v[k] ? v[k] : b.v[k]; });
  }
  PlainLanes larger(const PlainLanes& b) const {
    return each([&](int k) { return v[k] > b.v[k] ? v[k] : b.v[k]; });
  }
  double least() const { return *std::min_element(v, v + 4); }
  /// Which are.
  Flags below(const PlainLanes& b) const {
    unsigned bits = 0;
    for (int k = 0; k < 4; ++k) bits |= static_cast<unsigned>(v[k] < b.v[k]) << k;
    return {bits};
  }
  /// These where a flag is set, else the others.
  PlainLanes where(const Flags& flags, const PlainLanes& other) const {
    return each([&](int k) { return (flags.all >> k & 1) != 0 ? v[k] : other.v[k]; });
  }
  /// With its number, counted from `first`, in place of the last bits.
  PlainLanes numbered(std::size_t first, std::size_t count) const {
    return each([&](int k) {
      const auto bits = std::bit_cast<std::uint64_t>(v[k]) & ~(count - 1);
      return std::bit_cast<double>(bits | (first + static_cast<std::size_t>(k)));
    });
  }

 private:
  template <class Of>
  static PlainLanes each(const Of& of) {
    PlainLanes result;
    for (int k = 0; k < 4; ++k) result.v[k] = of(k);
    return result;
  }
};

}  // namespace
}  // namespace quoin::geometry
