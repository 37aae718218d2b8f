#pragma once
/// Records: functions of time from a CSV file.

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "scene_file/scene_file.hpp"

namespace quoin::scene_file {

/// A piecewise linear function; a time that stands twice is a jump.
struct Record {
  std::vector<double> times{};  ///< s
  std::vector<Vector3> values{};
};

/// Reads {"csv": PATH, "time": COLUMN, "value": COLUMN or three, "along", "scale", "baseline"}, as
/// the schema has it. Columns are found by the names in the first line; nothing is resampled.
/// Throws SceneError naming `pointer`, file, line and column, and FileError.
Record read_record(const nlohmann::json& value, const std::string& path,
                   const std::string& pointer);

/// Takes the line c0 + c1 t from an acceleration record, component by component, with which
/// velocity and displacement, integrated exactly from rest at its first time, are zero at its last,
/// and stay so: a jump to zero ends the record.
void correct_baseline(Record& record);

}  // namespace quoin::scene_file
