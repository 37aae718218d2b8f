#include "scene_file/read_record.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "scene_file/printable.hpp"
#include "scene_file/scene_error.hpp"

namespace quoin::scene_file {
namespace {

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r\"");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r\"") - first + 1);
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  for (std::size_t from = 0; from <= line.size();) {
    const std::size_t end = std::min(line.find_first_of(",;", from), line.size());
    fields.push_back(trimmed(line.substr(from, end - from)));
    from = end + 1;
  }
  return fields;
}

/// The wanted columns of a CSV file.
class Columns {
 public:
  Columns(const std::string& path, const std::string& pointer) : path_(path), pointer_(pointer) {}

  std::vector<std::vector<double>> read(const std::vector<std::string>& names) {
    std::ifstream file(path_);
    std::string line;
    if (!file || !std::getline(file, line)) throw FileError(path_ + ": can't be read");
    if (line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
    const std::vector<std::string> head = fields_of(line);
    std::vector<std::size_t> at;
    for (const std::string& name : names) {
      at.push_back(static_cast<std::size_t>(std::ranges::find(head, name) - head.begin()));
      if (at.back() == head.size()) fail("has no column " + shown(name));
    }
    std::vector<std::vector<double>> rows;
    for (std::size_t number = 2; std::getline(file, line); ++number) {
      if (trimmed(line).empty()) continue;
      const std::vector<std::string> fields = fields_of(line);
      if (fields.size() > head.size()) {
        fail("line " + std::to_string(number) + " has " + std::to_string(fields.size()) +
             " fields, the first one " + std::to_string(head.size()));
      }
      std::vector<double>& row = rows.emplace_back();
      for (std::size_t i = 0; i < at.size(); ++i)
        row.push_back(number_in(fields, at[i], names[i], number));
    }
    if (rows.empty()) fail("has no line of numbers");
    return rows;
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw SceneError(pointer_ + "/csv", path_ + ": " + what);
  }

 private:
  double number_in(const std::vector<std::string>& fields, std::size_t at, const std::string& name,
                   std::size_t line) const {
    const std::string text = at < fields.size() ? fields[at] : "";
    double value = NAN;
    const char* end = text.data() + text.size();
    const auto [stopped, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || stopped != end || !std::isfinite(value)) {
      fail("line " + std::to_string(line) + ", column " + shown(name) + ": must be a number, is " +
           shown(text));
    }
    return value;
  }

  const std::string& path_;
  const std::string& pointer_;
};

}  // namespace

Record read_record(const nlohmann::json& value, const std::string& path,
                   const std::string& pointer) {
  const bool vector = value["value"].is_array();
  std::vector<std::string> names{value["time"]};
  for (std::size_t i = 0; i < (vector ? 3 : 1); ++i)
    names.push_back(vector ? value["value"][i] : value["value"]);
  if (vector && value.contains("along"))
    throw SceneError(pointer + "/along", "three columns have their directions");
  Vector3 along = Vector3::UnitX();
  for (int i = 0; value.contains("along") && i < 3; ++i)
    along[i] = value["along"][static_cast<std::size_t>(i)];
  if (!(along.norm() > 0)) throw SceneError(pointer + "/along", "must not be zero");
  const double scale = value.value("scale", 1.0);
  Record record;
  Columns columns(path, pointer);
  for (const std::vector<double>& row : columns.read(names)) {
    const std::size_t n = record.times.size();
    if (n > 0 && !(row[0] >= record.times[n - 1] && (n < 2 || row[0] > record.times[n - 2]))) {
      columns.fail("times must ascend, each at most twice; " + shown(nlohmann::json(row[0])) +
                   " comes after " + shown(nlohmann::json(record.times[n - 1])));
    }
    record.times.push_back(row[0]);
    record.values.push_back(
        scale * (vector ? Vector3(row[1], row[2], row[3]) : Vector3(row[1] * along.normalized())));
  }
  if (value.contains("baseline")) {
    if (record.times.size() < 2)
      throw SceneError(pointer + "/baseline", path + " has one line, two or more are needed");
    correct_baseline(record);
  }
  return record;
}

void correct_baseline(Record& record) {
  Vector3 velocity = Vector3::Zero(), displacement = Vector3::Zero();
  for (std::size_t i = 1; i < record.times.size(); ++i) {
    const double h = record.times[i] - record.times[i - 1];
    const Vector3 &from = record.values[i - 1], &to = record.values[i];
    displacement += h * velocity + h * h / 6 * (2 * from + to);
    velocity += 0.5 * h * (from + to);
  }
  const double start = record.times.front(), length = record.times.back() - start;
  if (!(length > 0)) return;
  // c0 T + c1 T2/2 = v(T), c0 T2/2 + c1 T3/6 = u(T)
  const Vector3 mean = velocity / length, arm = displacement / (length * length);
  const Vector3 constant = 6 * arm - 2 * mean, slope = (6 * mean - 12 * arm) / length;
  for (std::size_t i = 0; i < record.times.size(); ++i)
    record.values[i] -= constant + slope * (record.times[i] - start);
  if (const double end = record.times.back(); record.times.end()[-2] < end) {
    record.times.push_back(end);
    record.values.emplace_back();
  }
  record.values.back() = Vector3::Zero();  // it rests from then on
}

}  // namespace quoin::scene_file
