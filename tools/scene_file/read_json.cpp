#include "scene_file/read_json.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "scene_file/printable.hpp"
#include "scene_file/scene_error.hpp"
#include "scene_file/scene_file.hpp"

namespace quoin::scene_file {
namespace {

using nlohmann::json;

/// No scene and no file of meshes is nested deeper.
constexpr std::size_t kMostDeep = 64;

/// Makes the document as the parser goes (nlohmann's SAX interface); refuses a key that an object
/// has already, and lists in lists without end. The package's own callback parser looks at all
/// elements of a list anew after each of them.
template <class Json>
class DocumentBuilder {
 public:
  bool null() { return put(nullptr); }
  bool boolean(bool value) { return put(value); }
  bool number_integer(json::number_integer_t value) { return put(value); }
  bool number_unsigned(json::number_unsigned_t value) { return put(value); }
  bool number_float(json::number_float_t value, const std::string& /*text*/) { return put(value); }
  bool string(std::string& value) { return put(std::move(value)); }
  bool binary(json::binary_t& value) { return put(std::move(value)); }
  bool start_object(std::size_t /*count*/) { return open(Json::object()); }
  bool start_array(std::size_t /*count*/) { return open(Json::array()); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }

  bool key(std::string& name) {
    const auto [place, is_new] = open_.back()->emplace(name, nullptr);
    if (!is_new) throw SceneError("", "the key " + shown(name) + " is given twice in one object");
    value_ = &*place;
    return true;
  }

  template <class Error>
  bool parse_error(std::size_t /*position*/, const std::string& /*token*/, const Error& error) {
    throw error;
  }

  Json document;

 private:
  bool put(Json&& value) {
    placed(std::move(value));
    return true;
  }

  Json& placed(Json&& value) {
    if (open_.empty()) return document = std::move(value);
    if (open_.back()->is_object()) return *value_ = std::move(value);
    open_.back()->push_back(std::move(value));
    return open_.back()->back();
  }

  bool open(Json&& container) {
    if (open_.size() >= kMostDeep)
      throw SceneError("", "nested too deep, the limit is " + std::to_string(kMostDeep));
    open_.push_back(&placed(std::move(container)));
    return true;
  }

  bool close() {
    open_.pop_back();
    return true;
  }

  std::vector<Json*> open_;  ///< the containers that the parser is in
  Json* value_ = nullptr;    ///< of the last key
};

template <class Json = json, class Text>
Json parsed(Text&& text, bool allow_comments) {
  DocumentBuilder<Json> builder;
  json::sax_parse(std::forward<Text>(text), &builder, json::input_format_t::json, true,
                  allow_comments);
  return std::move(builder.document);
}

/// A change may add a key, but no element of a list.
void require_place(const json& document, json::json_pointer place) {
  for (; !place.empty(); place.pop_back()) {
    const json::json_pointer parent = place.parent_pointer();
    if (document.contains(parent) && document[parent].is_array() && !document.contains(place))
      throw SceneError(place.to_string(), "there is no such place in the scene to change");
  }
}

/// JSON, or a bare word.
json parsed_value(const std::string& value, const std::string& pointer) {
  try {
    return parsed(value, false);
  } catch (const json::parse_error&) {
    if (printable(value, value.size()) != value)
      throw SceneError(pointer, "the new value holds control characters or is no UTF-8");
    return value;
  } catch (const json::exception& error) {  // a number that no double holds
    throw SceneError(pointer, plain_message(error));
  }
}

void change(json& document, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw SceneError("", "change " + shown(text) + " is not NAME=VALUE");
  const std::string name = text.substr(0, equals);
  const std::string value = text.substr(equals + 1);
  const std::string pointer = name[0] == '/' ? name : "/parameters/" + name;
  const json parsed = parsed_value(value, pointer);
  try {
    if (name[0] != '/' && !document.contains(json::json_pointer(pointer)))
      throw SceneError("/parameters", "the scene has no parameter " + shown(name) + " to change");
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
        const double number = Formula(text.substr(1), parameters, Formula::Clock::None).at(0.0);
        if (!std::isfinite(number))
          throw SceneError(pointer, shown(text) + " is not a finite number");
        value = number;
      } catch (const std::invalid_argument& error) {
        throw SceneError(pointer, error.what());
      }
    }
  } else if (value.is_structured()) {
    for (const auto& [key, item] : value.items())
      put_numbers(item, pointer + "/" + key, parameters);
  }
}

/// Leaves a formula as it is that names what is no number yet.
void put_number_if_known(json& value, const Parameters& parameters) {
  try {
    put_numbers(value, "", parameters);
  } catch (const SceneError&) {
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

template <class Json, class Text>
Json parsed_scene(Text&& text) {
  try {
    return parsed<Json>(std::forward<Text>(text), true);
  } catch (const json::exception& error) {
    throw SceneError("", plain_message(error));
  }
}

template <class Json>
Json read_as(const std::string& path) {
  std::ifstream file(path);
  if (!file || std::filesystem::is_directory(path))
    throw FileError((path.empty() ? "\"\"" : path) + ": can't be read");
  return parsed_scene<Json>(file);
}

}  // namespace

json parse_json(const std::string& text) { return parsed_scene<json>(text); }

json read_json(const std::string& path) { return read_as<json>(path); }

std::string plain_json(const std::string& path) {
  return read_as<nlohmann::ordered_json>(path).dump();
}

Parameters expand(nlohmann::json& document, const std::vector<std::string>& changes) {
  for (const std::string& text : changes) change(document, text);
  Parameters parameters;
  if (document.is_object() && document.contains("parameters")) {
    json& stated = document["parameters"];
    if (!stated.is_object()) {
      throw SceneError("/parameters",
                       "must be an object of names and numbers, is " + shown(stated));
    }
    parameters = numbers(stated);
    for (std::size_t known = 0; known < parameters.size();) {  // those made from others, in turns
      known = parameters.size();
      for (auto& value : stated) put_number_if_known(value, parameters);
      parameters = numbers(stated);
    }
    put_numbers(stated, "/parameters", parameters);  // what is left tells what is wrong with it
    parameters = numbers(stated);
  }
  put_numbers(document, "", parameters);
  return parameters;
}

}  // namespace quoin::scene_file
