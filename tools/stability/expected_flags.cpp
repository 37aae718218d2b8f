/// The list of flags that cells are known to raise.

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "stability/cell.hpp"
#include "stability/embedded.hpp"

namespace quoin::stability {
namespace {

/// The value as the list writes it.
std::string shown(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

std::string key(const std::string& row, const std::string& value) { return row + " = " + value; }

std::string key(const Cell& cell) {
  return key(row_name(cell), shown(cell.parameters.front().value));
}

std::size_t kind_of(const std::string& flag) {
  for (std::size_t kind = 0; kind < solver::kFlagKinds; ++kind) {
    if (name(static_cast<solver::FlagKind>(kind)) == flag) return kind;
  }
  throw std::runtime_error("expected_flags.json: there is no flag " + flag);
}

}  // namespace

std::string row_name(const Cell& cell) { return cell.parameters.front().name + " / " + cell.name; }

ExpectedFlags::ExpectedFlags(const std::vector<Cell>& cells) {
  std::set<std::string> known;
  for (const Cell& cell : cells) known.insert(key(cell));
  const auto list = nlohmann::ordered_json::parse(expected_flags());
  for (const auto& [row, values] : list.items()) {
    for (const auto& [value, flags] : values.items()) {
      const std::string cell = key(row, value);
      if (!known.contains(cell)) {
        throw std::runtime_error("expected_flags.json: there is no cell " + cell);
      }
      auto& names = by_cell_[cell] = flags.get<std::vector<std::string>>();
      std::ranges::sort(names, {}, kind_of);
    }
  }
}

const std::vector<std::string>& ExpectedFlags::of(const Cell& cell) const {
  static const std::vector<std::string> kNone;
  const auto found = by_cell_.find(key(cell));
  return found == by_cell_.end() ? kNone : found->second;
}

}  // namespace quoin::stability
