#include "scene_file/overrides.hpp"

#include <fnmatch.h>
#include <muParser.h>

#include <cmath>
#include <numbers>
#include <quoin/geometry/mass_properties.hpp>
#include <sstream>

#include "scene_file/mesh_surface.hpp"
#include "scene_file/scene_error.hpp"

namespace quoin::scene_file {
namespace {

using geometry::Vector3;
using nlohmann::json;

/// A condition of x, y, z (m), by muParser, with the names that formulas know.
class Condition {
 public:
  Condition(const std::string& text, const std::string& pointer, const Parameters& parameters)
      : text_(text), pointer_(pointer) {
    try {
      parser_.DefineConst("pi", std::numbers::pi);
      parser_.DefineConst("deg", std::numbers::pi / 180);
      for (const auto& [name, value] : parameters)
        if (name != "x" && name != "y" && name != "z") parser_.DefineConst(name, value);
      for (int axis = 0; axis < 3; ++axis)
        parser_.DefineVar(std::string(1, static_cast<char>('x' + axis)), &place_[axis]);
      parser_.SetExpr(text);
    } catch (const mu::Parser::exception_type& error) {
      throw SceneError(pointer_, error.GetMsg());
    }
  }
  Condition(const Condition&) = delete;  // the parser points at place_
  Condition& operator=(const Condition&) = delete;

  bool holds(const Vector3& place) {
    place_ = place;
    try {
      const double value = parser_.Eval();
      if (!std::isnan(value)) return value != 0.0;
    } catch (const mu::Parser::exception_type& error) {
      throw SceneError(pointer_, error.GetMsg());
    }
    std::ostringstream line;
    line << in_quotes(text_) << " is no number at (" << place.transpose() << ") m";
    throw SceneError(pointer_, line.str());
  }

 private:
  std::string text_, pointer_;
  Vector3 place_ = Vector3::Zero();
  mu::Parser parser_;
};

std::string text(const json& name) {
  return name.is_string() ? name.get<std::string>() : name.dump();
}

bool fits(const std::string& pattern, std::string_view name) {
  return !name.empty() &&
         (pattern == name || fnmatch(pattern.c_str(), std::string(name).c_str(), 0) == 0);
}

/// Flags what one name, id or pattern means.
void match_name(const json& name, const std::string& pointer, std::span<const BlockLabel> blocks,
                std::string_view what, std::vector<char>& meant) {
  const std::string pattern = text(name);
  bool any = false;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    if (fits(pattern, blocks[b].name) || fits(pattern, blocks[b].file_name)) {
      meant[b] = 1;
      any = true;
    }
  }
  if (!any)
    throw SceneError(pointer, "no " + std::string(what) + " is named " + in_quotes(pattern));
}

}  // namespace

std::vector<char> match_blocks(const json& names, const std::string& pointer,
                               std::span<const BlockLabel> blocks, std::string_view what) {
  std::vector<char> meant(blocks.size(), 0);
  for (std::size_t i = 0; names.is_array() && i < names.size(); ++i)
    match_name(names[i], pointer + "/" + std::to_string(i), blocks, what, meant);
  if (!names.is_array()) match_name(names, pointer, blocks, what, meant);
  return meant;
}

namespace {

std::vector<char> match(const json& value, const std::string& pointer,
                        std::span<const BlockLabel> blocks, const Parameters& parameters) {
  std::vector<char> meant = value.contains("blocks")
                                ? match_blocks(value["blocks"], pointer + "/blocks", blocks)
                                : std::vector<char>(blocks.size(), 1);
  if (value.contains("where")) {
    Condition condition(value["where"], pointer + "/where", parameters);
    bool any = false;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      meant[b] =
          meant[b] && condition.holds(geometry::mass_properties(blocks[b].block->body()).centroid);
      any = any || meant[b];
    }
    if (!any) {
      throw SceneError(pointer + "/where",
                       "no block's centroid meets " + in_quotes(value["where"].get<std::string>()));
    }
  }
  return meant;
}

}  // namespace

std::vector<std::vector<int>> match_overrides(const json& overrides,
                                              const std::string& list_pointer,
                                              std::span<const BlockLabel> blocks,
                                              const Parameters& parameters) {
  std::vector<std::vector<int>> result(blocks.size());
  for (std::size_t i = 0; i < overrides.size(); ++i) {
    const std::string pointer = list_pointer + "/" + std::to_string(i);
    if (!overrides[i].contains("blocks") && !overrides[i].contains("where"))
      throw SceneError(pointer, "needs \"blocks\" or \"where\": which blocks it means");
    const std::vector<char> meant = match(overrides[i], pointer, blocks, parameters);
    for (std::size_t b = 0; b < blocks.size(); ++b)
      if (meant[b]) result[b].push_back(static_cast<int>(i));
  }
  return result;
}

}  // namespace quoin::scene_file
