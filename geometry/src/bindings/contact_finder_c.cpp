#include <quoin/geometry/contact_finder.hpp>

#include "bindings/c_values.hpp"

namespace geometry = quoin::geometry;

struct quoin_finder {
  explicit quoin_finder(const geometry::FinderOptions& options) : finder(options) {}

  geometry::ContactFinder finder;
  std::vector<geometry::ContactPoint> contacts, asked;
  std::vector<quoin_contact_point> points;
  std::vector<quoin_pair> pairs;
  char message[256] = "";
};

namespace {

using namespace quoin::geometry::bindings;  // NOLINT: private to this file
/// Runs `work` on a finder, which keeps what was wrong.
template <class Work>
quoin_status with(quoin_finder* finder, Work&& work) {
  if (finder == nullptr) return QUOIN_BAD_INPUT;
  const auto run = [&] {
    work(finder->finder);
    return QUOIN_OK;
  };
  return guarded(run, finder->message, sizeof finder->message);
}

std::shared_ptr<const geometry::Shape> solid_of(const quoin_shape* shape) {
  require(shape != nullptr, "the shape is null");
  return shape->solid;
}

geometry::BodyOptions options_of(const quoin_body_options* options) {
  require(options != nullptr, "options is null");
  if (options->idle != 0 && options->idle != 1) {
    throw geometry::InputError("idle is " + std::to_string(options->idle) + ", must be 0 or 1");
  }
  return {options->category, options->collides_with,
          options->idle != 0 ? geometry::BodyMotion::Idle : geometry::BodyMotion::Moving};
}

}  // namespace

extern "C" {

quoin_status quoin_make_finder(const quoin_finder_options* options, quoin_finder** made,
                               char* message, size_t message_size) {
  say("", message, message_size);
  const auto make = [&] {
    require(options != nullptr && made != nullptr, "options or made is null");
    *made = new quoin_finder(
        {.reach = options->reach, .tolerance = options->tolerance, .threads = options->threads});
    return QUOIN_OK;
  };
  return guarded(make, message, message_size);
}

void quoin_free_finder(quoin_finder* finder) { delete finder; }

const char* quoin_finder_message(const quoin_finder* finder) {
  return finder == nullptr ? "" : finder->message;
}

quoin_body_options quoin_default_body_options(void) {
  const geometry::BodyOptions options;
  return {options.category, options.collides_with, 0};
}

quoin_status quoin_finder_add(quoin_finder* finder, const quoin_body* body,
                              const quoin_body_options* options, int* handle) {
  return with(finder, [&](geometry::ContactFinder& f) {
    require(body != nullptr && handle != nullptr, "body or handle is null");
    *handle = f.add(solid_of(body->shape), placement_of(body->placement),
                    options != nullptr ? options_of(options) : geometry::BodyOptions{});
  });
}

quoin_status quoin_finder_remove(quoin_finder* finder, int handle) {
  return with(finder, [&](geometry::ContactFinder& f) { f.remove(handle); });
}

quoin_status quoin_finder_move(quoin_finder* finder, int handle, const quoin_placement* placement) {
  return with(finder, [&](geometry::ContactFinder& f) {
    require(placement != nullptr, "placement is null");
    f.move(handle, placement_of(*placement));
  });
}

quoin_status quoin_finder_replace_shape(quoin_finder* finder, int handle,
                                        const quoin_shape* shape) {
  return with(finder,
              [&](geometry::ContactFinder& f) { f.replace_shape(handle, solid_of(shape)); });
}

quoin_status quoin_finder_set_options(quoin_finder* finder, int handle,
                                      const quoin_body_options* options) {
  return with(finder,
              [&](geometry::ContactFinder& f) { f.set_options(handle, options_of(options)); });
}

quoin_status quoin_finder_set_filter(quoin_finder* finder,
                                     int (*filter)(void* context, int a, int b), void* context) {
  return with(finder, [&](geometry::ContactFinder& f) {
    if (filter == nullptr) return f.set_filter({});
    f.set_filter([=](int a, int b) { return filter(context, a, b) != 0; });
  });
}

quoin_status quoin_finder_set_reach(quoin_finder* finder, double reach) {
  return with(finder, [&](geometry::ContactFinder& f) { f.set_reach(reach); });
}

quoin_status quoin_finder_set_body_reach(quoin_finder* finder, int handle, double reach) {
  return with(finder, [&](geometry::ContactFinder& f) { f.set_reach(handle, reach); });
}

int quoin_finder_size(const quoin_finder* finder) {
  return finder == nullptr ? 0 : finder->finder.size();
}

int quoin_finder_threads(const quoin_finder* finder) {
  return finder == nullptr ? 0 : finder->finder.threads();
}

quoin_status quoin_finder_find(quoin_finder* finder) {
  return with(finder, [&](geometry::ContactFinder& f) {
    f.find(finder->contacts);
    copy(finder->contacts, finder->points);
    copy(f.pairs(), finder->pairs);
  });
}

quoin_status quoin_finder_contacts_of(quoin_finder* finder, const int* handles, int handle_count,
                                      quoin_contact_point* points, int* count) {
  quoin_status status = QUOIN_OK;
  const quoin_status asked = with(finder, [&](geometry::ContactFinder& f) {
    require(handle_count >= 0 && (handles != nullptr || handle_count == 0),
            "handles is null, or their number is negative");
    require_room(points, count);
    f.contacts_of({handles, static_cast<std::size_t>(handle_count)}, finder->asked);
    status = give(finder->asked, points, *count);
  });
  return asked == QUOIN_OK ? status : asked;
}

const quoin_contact_point* quoin_finder_points(const quoin_finder* finder, int* count) {
  return finder == nullptr ? no_list<quoin_contact_point>(count) : list(finder->points, count);
}

const quoin_pair* quoin_finder_pairs(const quoin_finder* finder, int* count) {
  return finder == nullptr ? no_list<quoin_pair>(count) : list(finder->pairs, count);
}

}  // extern "C"
