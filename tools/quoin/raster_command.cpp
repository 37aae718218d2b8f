/// quoin raster: polygons on standard input, a picture on standard output. For picture.py alone.

#include <algorithm>
#include <cstdio>

#include "commands.hpp"
#include "raster/raster.hpp"
#include "scene_file/scene_error.hpp"

namespace quoin::commands {
namespace {

template <typename Number>
std::vector<Number> read(std::size_t count) {
  std::vector<Number> values(count);
  if (std::fread(values.data(), sizeof(Number), count, stdin) != count)
    throw scene_file::FileError("standard input: ends too early");
  return values;
}

template <typename Number>
void write(const std::vector<Number>& values) {
  if (std::fwrite(values.data(), sizeof(Number), values.size(), stdout) != values.size())
    throw scene_file::FileError("standard output: can't be written");
}

/// Width, height, samples, polygons, corners (int32); axes, centre, scale, light, line (double);
/// then the arrays of raster::Polygons in the order first, corners, colours.
int picture() {
  const std::vector<std::int32_t> sizes = read<std::int32_t>(5);
  if (std::ranges::any_of(sizes, [](std::int32_t size) { return size < 0; }))
    throw std::invalid_argument("raster: a size is negative");
  const std::vector<double> v = read<double>(16);
  raster::View view{sizes[0], sizes[1], sizes[2], {}, {v[9], v[10]}, v[11], {v[12], v[13], v[14]},
                    v[15]};
  view.axes << v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8];
  const auto polygons = static_cast<std::size_t>(sizes[3]),
             corners = static_cast<std::size_t>(sizes[4]);
  const std::vector<std::int32_t> first = read<std::int32_t>(polygons + 1);
  const std::vector<double> places = read<double>(3 * corners);
  const std::vector<float> colours = read<float>(3 * polygons);
  const raster::Image image = raster::draw({places, first, colours}, view);
  write(image.rgb);
  write(image.depth);
  write(image.polygons);
  return std::fflush(stdout) == 0 ? kDone : kFailed;
}

}  // namespace

void add_raster_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("raster", "Polygons from standard input as pixels");
  command->group("");  // not listed
  command->callback([&exit_code] { exit_code = run_guarded(picture, "raster"); });
}

}  // namespace quoin::commands
