#include "scene_file/schema_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>
#include <vector>

#include "scene_file/printable.hpp"
#include "scene_file/scene_error.hpp"

namespace quoin::scene_file {
namespace {

using nlohmann::json;

/// JSON pointer escapes: ~ and /.
std::string child(const std::string& pointer, const std::string& key) {
  std::string escaped;
  for (const char c : key) escaped += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return pointer + "/" + escaped;
}

std::string child(const std::string& pointer, std::size_t index) {
  return pointer + "/" + std::to_string(index);
}

bool is_of_type(const json& value, const std::string& type) {
  return (type == "object" && value.is_object()) || (type == "array" && value.is_array()) ||
         (type == "string" && value.is_string()) || (type == "number" && value.is_number()) ||
         (type == "integer" && value.is_number_integer()) ||
         (type == "boolean" && value.is_boolean());
}

std::string list(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return text;
}

/// Levenshtein distance: which known key was meant.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({change, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

std::vector<std::string> words_of(const std::string& key) {
  std::istringstream stream(key);
  std::vector<std::string> words;
  for (std::string word; std::getline(stream, word, '_');) words.push_back(word);
  return words;
}

/// How many words of `key` are in `known`: the same, or one begins with the other, and no unit.
std::size_t common_words(const std::string& key, const std::string& known) {
  constexpr std::size_t kShortest = 3;  // m, in
  const std::vector<std::string> words = words_of(known);
  std::size_t common = 0;
  for (const std::string& word : words_of(key)) {
    common += std::any_of(words.begin(), words.end(), [&](const std::string& other) {
      return word != "deg" && std::min(word.size(), other.size()) >= kShortest &&
             (word.starts_with(other) || other.starts_with(word));
    });
  }
  return common;
}

/// The known key within two changes; else the one with the most words in common and fewest others.
std::string meant(const std::string& key, const json& properties) {
  std::string best;
  std::size_t least = 3, most = 0, fewest = 0;
  for (const auto& [known, unused] : properties.items()) {
    const std::size_t distance = edit_distance(key, known);
    const std::size_t common = common_words(key, known), words = words_of(known).size();
    const bool shares =
        common > 0 && least == 3 && (common > most || (common == most && words < fewest));
    if (distance >= least && !shares) continue;
    least = std::min(least, distance);
    most = common;
    fewest = words;
    best = "; did you mean \"" + known + "\"?";
  }
  return best;
}

class Checker {
 public:
  explicit Checker(const json& root) : root_(root) {}

  void check(const json& schema, const json& value, const std::string& pointer) const {
    if (schema.contains("$ref")) {
      check(resolve(schema), value, pointer);
      return;
    }
    if (schema.contains("oneOf")) {
      check(chosen(schema["oneOf"], value, pointer), value, pointer);
      return;
    }
    check_type(schema, value, pointer);
    check_choice(schema, value, pointer);
    if (value.is_number())
      check_number(schema, value, pointer);
    else if (value.is_string())
      check_string(schema, value.get_ref<const std::string&>(), pointer);
    else if (value.is_array())
      check_array(schema, value, pointer);
    else if (value.is_object())
      check_object(schema, value, pointer);
  }

 private:
  const json& resolve(const json& schema) const {
    const json* target = &schema;
    while (target->contains("$ref"))
      target = &root_.at(json::json_pointer((*target)["$ref"].get<std::string>().substr(1)));
    return *target;
  }

  /// The alternatives of a oneOf, nested ones and references spread out.
  void spread(const json& alternatives, std::vector<const json*>& flat) const {
    for (const json& alternative : alternatives) {
      const json& target = resolve(alternative);
      if (target.contains("oneOf"))
        spread(target["oneOf"], flat);
      else
        flat.push_back(&target);
    }
  }

  static std::vector<std::string> types(const json& schema) {
    if (!schema.contains("type")) return {};
    const json& type = schema["type"];
    return type.is_array() ? type.get<std::vector<std::string>>()
                           : std::vector<std::string>{type.get<std::string>()};
  }

  static bool fits_type(const json& schema, const json& value) {
    const std::vector<std::string> allowed = types(schema);
    if (allowed.empty()) return !schema.contains("enum") || value.is_string();
    return std::any_of(allowed.begin(), allowed.end(),
                       [&](const std::string& type) { return is_of_type(value, type); });
  }

  /// The one alternative that a value is meant for: by its type, then by a constant key, then by a
  /// key that only this alternative requires.
  const json& chosen(const json& alternatives, const json& value,
                     const std::string& pointer) const {
    std::vector<const json*> all;
    spread(alternatives, all);
    std::vector<const json*> fitting;
    std::copy_if(all.begin(), all.end(), std::back_inserter(fitting),
                 [&](const json* schema) { return fits_type(*schema, value); });
    if (fitting.empty()) {
      std::vector<std::string> names;
      for (const json* schema : all) {
        const std::string name = types(*schema).empty() ? "string" : types(*schema)[0];
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
      }
      throw SceneError(pointer, "must be of type " + list(names) + ", is " + value.type_name());
    }
    return fitting.size() == 1 ? *fitting[0] : by_key(fitting, value, pointer);
  }

  const json& by_key(const std::vector<const json*>& schemas, const json& value,
                     const std::string& pointer) const {
    for (const auto& [key, property] : (*schemas[0])["properties"].items())
      if (property.contains("const")) return by_constant(schemas, key, value, pointer);
    std::vector<std::string> wanted;
    for (const json* schema : schemas) {
      bool all = true;
      std::string name;
      for (const std::string& key : (*schema)["required"].get<std::vector<std::string>>()) {
        if (common(schemas, key)) continue;
        all = all && value.contains(key);
        name = name.empty() ? "\"" + key + "\"" : name;
      }
      if (all) return *schema;
      wanted.push_back(name);
    }
    throw SceneError(pointer, "needs the key " + list(wanted));
  }

  static bool common(const std::vector<const json*>& schemas, const std::string& key) {
    return std::all_of(schemas.begin(), schemas.end(),
                       [&](const json* schema) { return (*schema)["properties"].contains(key); });
  }

  static const json& by_constant(const std::vector<const json*>& schemas, const std::string& key,
                                 const json& value, const std::string& pointer) {
    std::vector<std::string> names;
    for (const json* schema : schemas) {
      const json& constant = (*schema)["properties"][key]["const"];
      if (value.contains(key) && value[key] == constant) return *schema;
      names.push_back(constant.dump());
    }
    if (!value.contains(key))
      throw SceneError(pointer, "missing key \"" + key + "\" (" + list(names) + ")");
    throw SceneError(child(pointer, key), "must be " + list(names) + ", is " + shown(value[key]));
  }

  static void check_type(const json& schema, const json& value, const std::string& pointer) {
    const std::vector<std::string> allowed = types(schema);
    if (!allowed.empty() && !fits_type(schema, value))
      throw SceneError(pointer, "must be of type " + list(allowed) + ", is " + value.type_name());
  }

  static void check_choice(const json& schema, const json& value, const std::string& pointer) {
    if (schema.contains("enum") &&
        std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end()) {
      std::vector<std::string> names;
      for (const json& choice : schema["enum"]) names.push_back(choice.dump());
      throw SceneError(pointer, "must be " + list(names) + ", is " + shown(value));
    }
  }

  static void check_number(const json& schema, const json& value, const std::string& pointer) {
    const auto hold = [&](const char* key, const char* words, auto holds) {
      if (schema.contains(key) && !holds(value.get<double>(), schema[key].get<double>()))
        throw SceneError(pointer, std::string("must be ") + words + " " + schema[key].dump() +
                                      ", is " + shown(value));
    };
    hold("minimum", "at least", std::greater_equal<>());
    hold("maximum", "at most", std::less_equal<>());
    hold("exclusiveMinimum", "greater than", std::greater<>());
    hold("exclusiveMaximum", "less than", std::less<>());
    constexpr int kMost = std::numeric_limits<int>::max();
    if (value.is_number_integer() && std::abs(value.get<double>()) > kMost &&
        wants_integer(schema)) {
      throw SceneError(pointer,
                       "must be at most " + std::to_string(kMost) + " in size, is " + shown(value));
    }
  }

  static bool wants_integer(const json& schema) {
    const std::vector<std::string> allowed = types(schema);
    return std::find(allowed.begin(), allowed.end(), "integer") != allowed.end();
  }

  static void check_string(const json& schema, const std::string& text,
                           const std::string& pointer) {
    const std::size_t most = schema.value("maxLength", text.size());
    if (text.size() < schema.value("minLength", std::size_t{0}))
      throw SceneError(pointer, "must not be empty");
    if (text.size() > most) {
      throw SceneError(pointer, "must have at most " + std::to_string(most) + " characters, has " +
                                    std::to_string(text.size()));
    }
    if (schema.contains("maxLength") && printable(text, text.size()) != text)
      throw SceneError(pointer, "must not hold control characters, is " + shown(text));
  }

  void check_array(const json& schema, const json& value, const std::string& pointer) const {
    const std::size_t least = schema.value("minItems", std::size_t{0});
    const std::size_t most = schema.value("maxItems", value.size());
    if (value.size() < least || value.size() > most) {
      const std::string wanted = least == most          ? std::to_string(least)
                                 : value.size() < least ? "at least " + std::to_string(least)
                                                        : "at most " + std::to_string(most);
      throw SceneError(pointer,
                       "must have " + wanted + " items, has " + std::to_string(value.size()));
    }
    if (schema.contains("items"))
      for (std::size_t i = 0; i < value.size(); ++i)
        check(schema["items"], value[i], child(pointer, i));
  }

  void check_object(const json& schema, const json& value, const std::string& pointer) const {
    const json none = json::object();
    const json& properties = schema.contains("properties") ? schema["properties"] : none;
    const json& instead = schema.contains("x-instead") ? resolve(schema["x-instead"]) : none;
    for (const auto& [key, item] : value.items()) {
      if (properties.contains(key)) {
        check(properties[key], item, child(pointer, key));
      } else if (schema.contains("additionalProperties")) {
        const json& additional = schema["additionalProperties"];
        if (additional.is_boolean()) {
          throw SceneError(child(pointer, key),
                           "unknown key " + shown(key) +
                               (instead.contains(key) ? ": " + instead[key].get<std::string>()
                                                      : meant(key, properties)));
        }
        check(additional, item, child(pointer, key));
      }
    }
    for (const json& key : schema.value("required", json::array()))
      if (!value.contains(key.get<std::string>()))
        throw SceneError(pointer, "missing key " + key.dump());
  }

  const json& root_;
};

}  // namespace

void check_schema(const nlohmann::json& schema, const nlohmann::json& document) {
  Checker(schema).check(schema, document, "");
}

}  // namespace quoin::scene_file
