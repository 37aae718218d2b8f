/// `quoin contact`: pairs of point sets in, one line of JSON each; nearest features and contact
/// out.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/contact_point.hpp>
#include <quoin/geometry/published_search.hpp>
#include <string>
#include <string_view>

#include "commands.hpp"
#include "scene_file/printable.hpp"
#include "scene_file/read_json.hpp"
#include "scene_file/read_shape.hpp"
#include "scene_file/scene_error.hpp"

namespace quoin::commands {
namespace {

using Json = nlohmann::ordered_json;

/// One body of a pair: the hull of the points, where its vertices stood among them, its placement.
struct PlacedHull {
  geometry::Hull hull;
  geometry::Placement placement;
  geometry::Body body() const { return {hull.polyhedron, placement}; }
};

PlacedHull read_hull(const nlohmann::json& line, const char* body) {
  const std::string name = std::string("\"") + body + "\"";
  if (!line.contains(body)) throw geometry::InputError(name + " is missing");
  const scene_file::PlacedPoints placed = scene_file::read_placed_points(line[body], name);
  try {
    return {geometry::make_hull(placed.points), placed.placement};
  } catch (const geometry::InputError& error) {
    throw geometry::InputError(name + ": " + error.what());
  }
}

double read_tolerance(const nlohmann::json& line) {
  if (!line.contains("tol")) return 0.0;  // the default of each pair
  const nlohmann::json& tolerance = line["tol"];
  if (!tolerance.is_number() || !(tolerance.get<double>() > 0.0)) {
    throw geometry::InputError("\"tol\" is " + scene_file::shown(tolerance) +
                               ", must be a length above 0");
  }
  return tolerance.get<double>();
}

/// Adding 0 turns -0 into 0.
Json to_json(const geometry::Vector3& v) {
  return Json::array({v.x() + 0.0, v.y() + 0.0, v.z() + 0.0});
}

Json feature_json(const geometry::SupportSet& set, const geometry::Hull& hull) {
  Json vertices = Json::array();
  for (int v : set.vertices) vertices.push_back(hull.input_index[static_cast<std::size_t>(v)]);
  return {{"kind", name(set.kind)}, {"vertices", std::move(vertices)}};
}

Json points_json(const std::vector<geometry::ContactPoint>& points) {
  Json list = Json::array();
  for (const geometry::ContactPoint& point : points) {
    const bool edges = point.key.feature_a.kind == geometry::FeatureKind::Edge;
    list.push_back({{"kind", edges ? "edge-edge" : "vertex-face"},
                    {"point_a", to_json(point.point_a)},
                    {"point_b", to_json(point.point_b)},
                    {"gap", point.gap}});
  }
  return list;
}

Json contact_json(const geometry::Hull& a, const geometry::Hull& b,
                  const geometry::PairContact& contact) {
  const geometry::NearestFeatures& nearest = contact.nearest;
  Json polygon = Json::array();
  if (contact.polygon.size() > 1)  // one point is neither a polygon nor a segment
    for (const geometry::Vector3& corner : contact.polygon) polygon.push_back(to_json(corner));
  Json features;
  features["a"] = feature_json(contact.support_a, a);
  features["b"] = feature_json(contact.support_b, b);
  return {{"status", name(nearest.status)},
          {"gap", nearest.gap},
          {"normal", to_json(nearest.normal)},
          {"point_a", to_json(nearest.point_a)},
          {"point_b", to_json(nearest.point_b)},
          {"type", name(contact.type)},
          {"features", std::move(features)},
          {"indeterminate", nearest.indeterminate},
          {"points", points_json(contact.points)},
          {"area", contact.area},
          {"polygon", std::move(polygon)},
          {"certificate", {{"residual_a", nearest.residual_a}, {"residual_b", nearest.residual_b}}},
          {"iterations", nearest.iterations}};
}

/// What the published search says, and what the certificate says of that. A vertex may lie within
/// tol of its support plane.
Json published_json(const geometry::PublishedAnswer& found, double tolerance) {
  return {{"gap", found.gap},
          {"normal", to_json(found.normal)},
          {"point_a", to_json(found.point_a)},
          {"point_b", to_json(found.point_b)},
          {"certificate", {{"residual_a", found.residual_a}, {"residual_b", found.residual_b}}},
          {"least_gap", found.least_gap()},
          {"proved", found.gap - found.least_gap() <= tolerance},
          {"cycles", found.cycles},
          {"stands_still", found.stands_still}};
}

/// The id of a line that is no JSON, if it can be made out.
Json salvaged_id(const std::string& text) {
  const std::size_t key = text.find("\"id\"");
  const std::size_t colon = key == std::string::npos ? key : text.find(':', key);
  if (colon == std::string::npos) return nullptr;
  const std::size_t end = text.find_first_of(",}", colon);
  const Json id = Json::parse(text.substr(colon + 1, end - colon - 1), nullptr, false);
  return id.is_discarded() ? Json(nullptr) : id;
}

/// Beside what is worked with, a pair may say where it is from and what its answer is.
void check_keys(const Json& line) {
  constexpr std::string_view kKeys[] = {"id", "a", "b", "tol", "source", "what", "exact", "expect"};
  for (const auto& [key, value] : line.items())
    if (std::find(std::begin(kKeys), std::end(kKeys), key) == std::end(kKeys))
      throw geometry::InputError("unknown key " + scene_file::shown(key));
}

/// Whose answers are wanted, how much of them, and what the published search did.
struct Question {
  bool published = false;
  double reach = 0.0;               // m
  geometry::PairContact contact{};  // memory that is used again
  long pairs = 0, proved = 0, never_still = 0;
};

Json published_answer(const PlacedHull& a, const PlacedHull& b, double tolerance,
                      Question& question) {
  const geometry::Body body_a = a.body(), body_b = b.body();
  const double length = tolerance > 0.0 ? tolerance : default_tolerance(body_a, body_b);
  const geometry::PublishedAnswer found = published_search(body_a, body_b);
  Json result = published_json(found, length);
  ++question.pairs;
  question.proved += result["proved"].get<bool>() ? 1 : 0;
  question.never_still += found.stands_still ? 0 : 1;
  return result;
}

Json contact_answer(const PlacedHull& a, const PlacedHull& b, double tolerance,
                    Question& question) {
  geometry::PairContact& contact = question.contact;
  update_pair_contact(a.body(), b.body(), {.tolerance = tolerance, .reach = question.reach},
                      contact);
  if (contact.nearest.status == geometry::PairStatus::NotConverged) {
    throw geometry::InputError("the search did not converge in " +
                               std::to_string(contact.nearest.iterations) + " iterations");
  }
  return contact_json(a.hull, b.hull, contact);
}

/// The answer to one line.
Json answer(const std::string& text, long number, Question& question, bool& bad) {
  Json result;
  result["id"] = nullptr;
  try {
    const Json line = scene_file::parse_json(text);
    if (!line.is_object()) throw geometry::InputError("the line is not a JSON object");
    result["id"] = line.value("id", Json(nullptr));
    check_keys(line);
    const PlacedHull a = read_hull(line, "a"), b = read_hull(line, "b");
    const auto& said = question.published ? published_answer : contact_answer;
    result.update(said(a, b, read_tolerance(line), question));
  } catch (const geometry::InputError& error) {
    bad = true;
    result["error"] = "line " + std::to_string(number) + ": " + error.what();
  } catch (const scene_file::SceneError& error) {
    bad = true;
    result["id"] = salvaged_id(text);
    result["error"] = "line " + std::to_string(number) + " is not JSON: " + error.what();
  }
  return result;
}

int contact_pairs(const std::string& path, Question& question) {
  std::ifstream file;
  if (path != "-") {
    file.open(path);
    if (!file || std::filesystem::is_directory(path)) {
      std::fprintf(stderr, "quoin contact: can't read %s\n", path.c_str());
      return kFailed;
    }
  }
  std::istream& in = path == "-" ? std::cin : file;
  std::ios::sync_with_stdio(false);
  bool bad = false;
  long number = 0;
  for (std::string text; std::getline(in, text);) {
    ++number;
    if (text.find_first_not_of(" \t\r") == std::string::npos) continue;
    const std::string line =
        answer(text, number, question, bad).dump(-1, ' ', false, Json::error_handler_t::replace);
    std::printf("%s\n", line.c_str());
  }
  if (std::fflush(stdout) != 0) {
    std::fprintf(stderr, "quoin contact: can't write the output\n");
    return kFailed;
  }
  if (question.published) {
    std::fprintf(stderr, "published search: %ld pairs, %ld proved, %ld never still\n",
                 question.pairs, question.proved, question.never_still);
  }
  return bad ? kBadInput : kDone;
}

}  // namespace

void add_contact_command(CLI::App& app, int& exit_code) {
  struct Options {
    std::string pairs, search = "certified";
    double reach = 0.0;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "contact", "Nearest features, contact type and points of pairs of convex point sets");
  command
      ->add_option(
          "--pairs", options->pairs,
          "One JSON object a line: {\"id\", \"a\": [[x,y,z],…], \"b\", \"tol\"} (m), or \"a\": "
          "{\"points\": …, \"placement\": [t, A by rows]}; \"source\", \"what\", \"exact\" are "
          "notes; - for standard "
          "input")
      ->required();
  command->add_option("--reach", options->reach,
                      "List contact points up to this gap above the least one, m (default: tol)");
  command
      ->add_option("--search", options->search,
                   "certified: the library's answer; published: what the paper's search finds as "
                   "printed, and whether the certificate proves it")
      ->check(CLI::IsMember({"certified", "published"}))
      ->capture_default_str();
  command->callback([options, &exit_code] {
    if (!(options->reach >= 0.0) || !std::isfinite(options->reach)) {
      throw CLI::ValidationError("--reach", "must be a length of 0 or more, m");
    }
    Question question{.published = options->search == "published", .reach = options->reach};
    exit_code = contact_pairs(options->pairs, question);
  });
}

}  // namespace quoin::commands
