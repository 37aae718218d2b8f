#include "scene_file/read_json.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>

#include "scene_file/scene_error.hpp"
#include "scene_file/shown.hpp"

namespace quoin::scene_file {
namespace {

using nlohmann::json;

/// No scene and no file of meshes is nested deeper.
constexpr int kMostDeep = 64;

/// Watches the parser for a key that an object has already, and for lists in lists without end.
class KeyWatch {
 public:
  bool operator()(int depth, json::parse_event_t event, json& parsed) {
    if (depth >= kMostDeep) {
      throw SceneError("", "nested too deep, the limit is " + std::to_string(kMostDeep));
    }
    if (event == json::parse_event_t::object_start) {
      open_.emplace_back();
    } else if (event == json::parse_event_t::object_end) {
      open_.pop_back();
    } else if (event == json::parse_event_t::key) {
      const std::string& key = parsed.get_ref<const std::string&>();
      if (!open_.back().insert(key).second) {
        throw SceneError("", "the key " + shown(key) + " is given twice in one object");
      }
    }
    return true;
  }

 private:
  std::vector<std::set<std::string>> open_;
};

/// A change may add a key, but no element of a list.
void require_place(const json& document, json::json_pointer place) {
  for (; !place.empty(); place.pop_back()) {
    const json::json_pointer parent = place.parent_pointer();
    if (document.contains(parent) && document[parent].is_array() && !document.contains(place)) {
      throw SceneError(place.to_string(), "there is no such place in the scene to change");
    }
  }
}

/// JSON, or a bare word.
json parsed_value(const std::string& value, const std::string& pointer) {
  try {
    return json::parse(value, KeyWatch());
  } catch (const json::parse_error&) {
    if (printable(value, value.size()) != value) {
      throw SceneError(pointer, "the new value holds control characters or is no UTF-8");
    }
    return value;
  }
}

void change(json& document, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw SceneError("", "change " + shown(text) + " is not NAME=VALUE");
  }
  const std::string name = text.substr(0, equals);
  const std::string value = text.substr(equals + 1);
  const std::string pointer = name[0] == '/' ? name : "/parameters/" + name;
  const json parsed = parsed_value(value, pointer);
  try {
    if (name[0] != '/' && !document.contains(json::json_pointer(pointer))) {
      throw SceneError("/parameters", "the scene has no parameter " + shown(name) + " to change");
    }
    require_place(document, json::json_pointer(pointer));
    document[json::json_pointer(pointer)] = parsed;
  } catch (const json::exception&) {
    throw SceneError(pointer, "there is no such place in the scene to change");
  }
}

void put_numbers(json& value, const std::string& pointer, const Parameters& parameters) {
  if (value.is_string()) {
    const std::string& text = value.get_ref<const std::string&>();
    if (text.starts_with('=')) {
      try {
        const double number = Formula(text.substr(1), parameters).at(0.0);
        if (!std::isfinite(number)) {
          throw SceneError(pointer, shown(text) + " is not a finite number");
        }
        value = number;
      } catch (const std::invalid_argument& error) {
        throw SceneError(pointer, error.what());
      }
    }
  } else if (value.is_structured()) {
    for (const auto& [key, item] : value.items()) {
      put_numbers(item, pointer + "/" + key, parameters);
    }
  }
}

Parameters numbers(const json& parameters) {
  Parameters known;
  for (const auto& [name, value] : parameters.items()) {
    if (!Formula::may_name(name)) {
      throw SceneError("/parameters",
                       shown(name) +
                           " can't be the name of a parameter: it must be a word that "
                           "formulas do not know");
    }
    if (value.is_number()) {
      known[name] = value.get<double>();
    } else if (!value.is_string() || !value.get_ref<const std::string&>().starts_with('=')) {
      throw SceneError("/parameters/" + name,
                       "must be a number or a formula that begins with =, is " + shown(value));
    }
  }
  return known;
}

}  // namespace

std::string plain_message(const nlohmann::json::exception& error) {
  const std::string message = error.what();
  const std::size_t start = message.find("] ");
  return printable(start == std::string::npos ? message : message.substr(start + 2), 300);
}

namespace {

template <class Text>
json parsed(Text&& text) {
  try {
    return json::parse(std::forward<Text>(text), KeyWatch(), true, true);
  } catch (const json::exception& error) {
    throw SceneError("", plain_message(error));
  }
}

}  // namespace

json parse_json(const std::string& text) { return parsed(text); }

json read_json(const std::string& path) {
  std::ifstream file(path);
  if (!file || std::filesystem::is_directory(path)) {
    throw FileError((path.empty() ? "\"\"" : path) + ": can't be read");
  }
  return parsed(file);
}

Parameters expand(nlohmann::json& document, const std::vector<std::string>& changes) {
  for (const std::string& text : changes) {
    change(document, text);
  }
  Parameters parameters;
  if (document.is_object() && document.contains("parameters")) {
    json& stated = document["parameters"];
    if (!stated.is_object()) {
      throw SceneError("/parameters",
                       "must be an object of names and numbers, is " + shown(stated));
    }
    parameters = numbers(stated);
    put_numbers(stated, "/parameters", parameters);  // those made from others
    parameters = numbers(stated);
  }
  put_numbers(document, "", parameters);
  return parameters;
}

}  // namespace quoin::scene_file
