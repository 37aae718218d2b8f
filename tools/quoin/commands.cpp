#include "commands.hpp"

#include <cstdio>
#include <new>
#include <nlohmann/json.hpp>

#include "scene_file/printable.hpp"
#include "scene_file/scene_error.hpp"

#include <quoin/geometry/shape.hpp>

namespace quoin::commands {

void complain(const std::string& message, const std::string& subject) {
  constexpr std::size_t kMost = 600;  // bytes: what is longer is no line for a person
  std::fprintf(stderr, "%s: %s\n", scene_file::printable(subject, kMost).c_str(),
               scene_file::printable(message, kMost).c_str());
}

const char* words(const nlohmann::ordered_json& string) {
  return string.get_ref<const std::string&>().c_str();
}

std::string text(const nlohmann::ordered_json& document) {
  return document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

namespace {

/// Where in the scene: the solver's messages begin with what they are about.
std::string with_place(const geometry::InputError& error) {
  const std::string message = error.what();
  return (message.starts_with("block") ? "/blocks: " : "/: ") + message;
}

}  // namespace

Ending ending_of(const std::function<int()>& command, const std::string& scene) {
  try {
    return {command()};
  } catch (const scene_file::SceneError& error) {
    return {kBadInput, error.what(), scene};
  } catch (const geometry::InputError& error) {
    return {kBadInput, with_place(error), scene};
  } catch (const std::invalid_argument& error) {
    return {kBadInput, error.what()};
  } catch (const std::bad_alloc&) {
    return {kFailed, "out of memory"};
  } catch (const std::exception& error) {
    return {kFailed, error.what()};
  }
}

int run_guarded(const std::function<int()>& command, const std::string& scene) {
  const Ending ending = ending_of(command, scene);
  if (!ending.message.empty()) complain(ending.message, ending.subject);
  return ending.exit_code;
}

void add_scene_options(CLI::App& command, std::string& scene, std::vector<std::string>& changes) {
  command.add_option("scene", scene, "scene file, JSON")->required();
  command.add_option("--set", changes, "change the scene before it is read, as in run")
      ->type_name("NAME=VALUE");
}

}  // namespace quoin::commands
