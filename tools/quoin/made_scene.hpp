#pragma once
/// A scene that `quoin make` writes: one block a line, to be read and changed.

#include <Eigen/Geometry>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace quoin::commands {

inline constexpr double kDegree = std::numbers::pi / 180;  ///< rad
inline constexpr int kMostBlocks = 1000000;                ///< of a made scene

/// What every made scene has.
struct Stone {
  double density = 2400;  ///< kg/m3
  double young = 0;       ///< Pa; 0: rigid
  double friction_deg = 35;
  double push = 0;      ///< of each block's weight, along x, by a load of that name
  double end_time = 0;  ///< s; 0, where it is not given: the shape's own
  std::string out;      ///< file; empty: standard output
};

nlohmann::ordered_json vector(const Eigen::Vector3d& v);  ///< m, rounded to a picometre
nlohmann::ordered_json box(const Eigen::Vector3d& min, const Eigen::Vector3d& max);
nlohmann::ordered_json prism(const std::vector<Eigen::Vector3d>& polygon,
                             const Eigen::Vector3d& sweep);
nlohmann::ordered_json hull(const std::vector<Eigen::Vector3d>& points);
std::string numbered(const std::string& stem, int number);
std::string numbered(const std::string& stem, int first, int second);

/// The same numbers from the same seed everywhere.
class Uniform {
 public:
  explicit Uniform(int seed) : random_(static_cast<std::uint64_t>(seed)) {}
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11U) * 0x1p-53;
  }

 private:
  std::mt19937_64 random_;
};

/// A scene, one block a line: `head` has all keys but "blocks".
std::string scene_text(const nlohmann::ordered_json& head, const nlohmann::ordered_json& blocks);

/// To a file that is not there yet, or (no path) to standard output. Throws FileError.
void save_text(const std::string& path, const std::string& text);

/// The blocks of a scene, and the rest of it.
class Made {
 public:
  using json = nlohmann::ordered_json;

  /// Throws std::invalid_argument where `blocks`, supports left out, are more than kMostBlocks.
  Made(const Stone& stone, std::string title, double blocks);

  json& add(const std::string& name, json shape);
  /// A box by its lowest corner: those of one size share their shape.
  json& add_box(const std::string& name, const Eigen::Vector3d& corner,
                const Eigen::Vector3d& size);
  void add_turned(const std::string& name, json shape, const Eigen::Quaterniond& turn,
                  const Eigen::Vector3d& about);
  json& add_fixed(const std::string& name, json shape);
  /// Another material, whose blocks slide on each other without friction.
  void add_smooth_material(const std::string& name, double density);
  void watch(const std::string& block);
  /// A number that the scene's formulas know by name.
  void set(const std::string& parameter, double value);

  /// The scene comes to rest, then moves for `end_time` where that is not 0.
  void save_standing(double time_step) const;
  /// The scene moves from the start.
  void save_moving(double time_step, double otherwise) const;
  /// The scene comes to rest; then it moves, with what `change` says of that stage.
  void save_changing(double time_step, double otherwise, const json& change) const;
  void save(double time_step, const json& stages) const;
  double end_time(double otherwise) const;  ///< s

 private:
  const Stone& stone_;
  std::string title_;
  json parameters_;
  json materials_ = json::object(), joints_ = json::array();
  json blocks_ = json::array();
  json monitors_ = json::array();
};

}  // namespace quoin::commands
