#include "scene_file/read_json.hpp"

#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>

#include "scene_file/scene_error.hpp"

namespace quoin::scene_file {
namespace {

using nlohmann::json;

/// Watches the parser for a key that an object has already.
class KeyWatch {
 public:
  bool operator()(int, json::parse_event_t event, json& parsed) {
    if (event == json::parse_event_t::object_start) {
      open_.emplace_back();
    } else if (event == json::parse_event_t::object_end) {
      open_.pop_back();
    } else if (event == json::parse_event_t::key) {
      const std::string& key = parsed.get_ref<const std::string&>();
      if (!open_.back().insert(key).second) {
        throw SceneError("", "the key \"" + key + "\" is given twice in one object");
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

void change(json& document, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw SceneError("", "change \"" + text + "\" is not NAME=VALUE");
  }
  const std::string name = text.substr(0, equals);
  const std::string value = text.substr(equals + 1);
  const std::string pointer = name[0] == '/' ? name : "/parameters/" + name;
  if (name[0] != '/' && !document.contains(json::json_pointer(pointer))) {
    throw SceneError("/parameters", "the scene has no parameter \"" + name + "\" to change");
  }
  const json parsed = json::parse(value, nullptr, false);
  try {
    require_place(document, json::json_pointer(pointer));
    document[json::json_pointer(pointer)] = parsed.is_discarded() ? json(value) : parsed;
  } catch (const json::exception&) {
    throw SceneError(pointer, "there is no such place in the scene to change");
  }
}

void put_numbers(json& value, const std::string& pointer, const Parameters& parameters) {
  if (value.is_string()) {
    const std::string& text = value.get_ref<const std::string&>();
    if (text.starts_with('=')) {
      try {
        value = Formula(text.substr(1), parameters).at(0.0);
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
    if (value.is_number()) {
      known[name] = value.get<double>();
    } else if (!value.is_string() || !value.get_ref<const std::string&>().starts_with('=')) {
      throw SceneError("/parameters/" + name,
                       "must be a number or a formula that begins with =, is " + value.dump());
    }
  }
  return known;
}

}  // namespace

nlohmann::json read_json(const std::string& path) {
  std::ifstream file(path);
  if (!file || std::filesystem::is_directory(path)) {
    throw FileError(path + ": can't be read");
  }
  try {
    return json::parse(file, KeyWatch(), true, true);
  } catch (const json::parse_error& error) {
    const std::string message = error.what();
    const std::size_t start = message.find("] ");
    throw SceneError("", start == std::string::npos ? message : message.substr(start + 2));
  }
}

Parameters expand(nlohmann::json& document, const std::vector<std::string>& changes) {
  for (const std::string& text : changes) {
    change(document, text);
  }
  Parameters parameters;
  if (document.is_object() && document.contains("parameters")) {
    json& stated = document["parameters"];
    if (!stated.is_object()) {
      throw SceneError("/parameters", "must be an object of names and numbers, is " + stated.dump());
    }
    parameters = numbers(stated);
    put_numbers(stated, "/parameters", parameters);  // those made from others
    parameters = numbers(stated);
  }
  put_numbers(document, "", parameters);
  return parameters;
}

}  // namespace quoin::scene_file
