#include <quoin/geometry/contact_finder.hpp>

#include "bindings/c_values.hpp"

namespace geometry = quoin::geometry;

struct quoin_finder {
  explicit quoin_finder(const geometry::FinderOptions& options) : finder(options) {}

  geometry::ContactFinder finder;
  std::vector<geometry::ContactPoint> contacts, asked;
  std::vector<geometry::BodyHit> hits;
  std::vector<int> handles;
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
  if (options->idle != 0 && options->idle != 1)
    throw geometry::InputError("idle is " + std::to_string(options->idle) + ", must be 0 or 1");
  return {options->category, options->collides_with,
          options->idle != 0 ? geometry::BodyMotion::Idle : geometry::BodyMotion::Moving};
}

geometry::QueryFilter filter_of(const quoin_query_filter* filter) {
  if (filter == nullptr) return {};
  geometry::QueryFilter made{.categories = filter->categories};
  if (filter->accepts != nullptr)
    made.accepts = [=](int handle) { return filter->accepts(filter->context, handle) != 0; };
  return made;
}

quoin_body_hit hit_to_c(const geometry::BodyHit& found) { return {found.handle, to_c(found.hit)}; }

/// As many as there is room for. `count` in: room, out: how many.
template <class From, class To, class Convert>
quoin_status give_all(const std::vector<From>& found, To* to, int& count, const Convert& convert) {
  const std::size_t room = static_cast<std::size_t>(count);
  count = static_cast<int>(found.size());
  std::transform(found.begin(),
                 found.begin() + static_cast<std::ptrdiff_t>(std::min(room, found.size())), to,
                 convert);
  return found.size() > room ? QUOIN_TOO_MANY : QUOIN_OK;
}

/// Runs a query on a finder that fills its `handles`, and gives them to the caller.
template <class Work>
quoin_status give_handles(quoin_finder* finder, int* handles, int* count, const Work& work) {
  quoin_status status = QUOIN_OK;
  const quoin_status asked = with(finder, [&](geometry::ContactFinder& f) {
    require_room(handles, count);
    work(f);
    status = give_all(finder->handles, handles, *count, [](int handle) { return handle; });
  });
  return asked == QUOIN_OK ? status : asked;
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

quoin_status quoin_finder_add_compound(quoin_finder* finder, const quoin_body* parts, int count,
                                       const quoin_placement* placement,
                                       const quoin_body_options* options, int* handle) {
  return with(finder, [&](geometry::ContactFinder& f) {
    require(parts != nullptr && count > 0 && handle != nullptr,
            "parts or handle is null, or there are no parts");
    std::vector<geometry::CompoundPart> made;
    for (int k = 0; k < count; ++k)
      made.push_back({solid_of(parts[k].shape), placement_of(parts[k].placement)});
    *handle = f.add_compound(made, placement_of(placement ? *placement : quoin_no_placement()),
                             options != nullptr ? options_of(options) : geometry::BodyOptions{});
  });
}

quoin_status quoin_finder_part_name(quoin_finder* finder, int handle, int* compound, int* part) {
  return with(finder, [&](geometry::ContactFinder& f) {
    require(compound != nullptr && part != nullptr, "an argument is null");
    const geometry::PartName name = f.part_name(handle);
    *compound = name.compound;
    *part = name.part;
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

quoin_status quoin_finder_nearest_hit(quoin_finder* finder, const quoin_ray* ray,
                                      const quoin_query_filter* filter, quoin_body_hit* hit,
                                      int* hits) {
  return with(finder, [&](geometry::ContactFinder& f) {
    require(hit != nullptr && hits != nullptr, "an argument is null");
    const auto found = f.nearest_hit(ray_of(ray), filter_of(filter));
    *hits = found.has_value() ? 1 : 0;
    if (found) *hit = hit_to_c(*found);
  });
}

quoin_status quoin_finder_all_hits(quoin_finder* finder, const quoin_ray* ray,
                                   const quoin_query_filter* filter, quoin_body_hit* hits,
                                   int* count) {
  quoin_status status = QUOIN_OK;
  const quoin_status asked = with(finder, [&](geometry::ContactFinder& f) {
    require_room(hits, count);
    f.all_hits(ray_of(ray), finder->hits, filter_of(filter));
    status = give_all(finder->hits, hits, *count, hit_to_c);
  });
  return asked == QUOIN_OK ? status : asked;
}

quoin_status quoin_finder_bodies_in_box(quoin_finder* finder, const double* min, const double* max,
                                        const quoin_query_filter* filter, int* handles,
                                        int* count) {
  return give_handles(finder, handles, count, [&](geometry::ContactFinder& f) {
    require(min != nullptr && max != nullptr, "a corner of the box is null");
    f.bodies_in_box({vector_of(min), vector_of(max)}, finder->handles, filter_of(filter));
  });
}

quoin_status quoin_finder_bodies_at(quoin_finder* finder, const double* point, double tolerance,
                                    const quoin_query_filter* filter, int* handles, int* count) {
  return give_handles(finder, handles, count, [&](geometry::ContactFinder& f) {
    require(point != nullptr, "the point is null");
    f.bodies_at(vector_of(point), tolerance, finder->handles, filter_of(filter));
  });
}

const quoin_contact_point* quoin_finder_points(const quoin_finder* finder, int* count) {
  return finder == nullptr ? no_list<quoin_contact_point>(count) : list(finder->points, count);
}

const quoin_pair* quoin_finder_pairs(const quoin_finder* finder, int* count) {
  return finder == nullptr ? no_list<quoin_pair>(count) : list(finder->pairs, count);
}

}  // extern "C"
