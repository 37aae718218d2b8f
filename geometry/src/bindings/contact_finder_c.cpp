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

namespace quoin::geometry {

static quoin_body_hit to_c(const BodyHit& found) {
  return {found.handle, bindings::to_c(found.hit)};
}

}  // namespace quoin::geometry

namespace {

using namespace quoin::geometry::bindings;  // NOLINT: private to this file
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

/// Runs a query on a finder that fills its `handles`, and gives them to the caller.
template <class Work>
quoin_status give_handles(quoin_finder* finder, int* handles, int* count, const Work& work) {
  return with(finder, [&](quoin_finder& f) {
    require_room(handles, count);
    work(f.finder);
    return give(f.handles, handles, *count);
  });
}

}  // namespace

extern "C" {

quoin_status quoin_make_finder(const quoin_finder_options* options, quoin_finder** made,
                               char* message, size_t message_size) {
  say("", message, message_size);
  return guarded(
      [&] {
        require(options != nullptr && made != nullptr, "options or made is null");
        *made = new quoin_finder({.reach = options->reach,
                                  .tolerance = options->tolerance,
                                  .threads = options->threads});
      },
      message, message_size);
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
  return with(finder, [&](quoin_finder& f) {
    require(body != nullptr && handle != nullptr, "body or handle is null");
    *handle = f.finder.add(solid_of(body->shape), placement_of(body->placement),
                           options != nullptr ? options_of(options) : geometry::BodyOptions{});
  });
}

quoin_status quoin_finder_add_compound(quoin_finder* finder, const quoin_body* parts, int count,
                                       const quoin_placement* placement,
                                       const quoin_body_options* options, int* handle) {
  return with(finder, [&](quoin_finder& f) {
    require(parts != nullptr && count > 0 && handle != nullptr,
            "parts or handle is null, or there are no parts");
    std::vector<geometry::CompoundPart> made;
    for (int k = 0; k < count; ++k)
      made.push_back({solid_of(parts[k].shape), placement_of(parts[k].placement)});
    *handle =
        f.finder.add_compound(made, placement_of(placement ? *placement : quoin_no_placement()),
                              options != nullptr ? options_of(options) : geometry::BodyOptions{});
  });
}

quoin_status quoin_finder_part_name(quoin_finder* finder, int handle, int* compound, int* part) {
  return with(finder, [&](quoin_finder& f) {
    require(compound != nullptr && part != nullptr, "an argument is null");
    const geometry::PartName name = f.finder.part_name(handle);
    *compound = name.compound;
    *part = name.part;
  });
}

quoin_status quoin_finder_remove(quoin_finder* finder, int handle) {
  return with(finder, [&](quoin_finder& f) { f.finder.remove(handle); });
}

quoin_status quoin_finder_move(quoin_finder* finder, int handle, const quoin_placement* placement) {
  return with(finder, [&](quoin_finder& f) {
    require(placement != nullptr, "placement is null");
    f.finder.move(handle, placement_of(*placement));
  });
}

quoin_status quoin_finder_replace_shape(quoin_finder* finder, int handle,
                                        const quoin_shape* shape) {
  return with(finder, [&](quoin_finder& f) { f.finder.replace_shape(handle, solid_of(shape)); });
}

quoin_status quoin_finder_set_options(quoin_finder* finder, int handle,
                                      const quoin_body_options* options) {
  return with(finder, [&](quoin_finder& f) { f.finder.set_options(handle, options_of(options)); });
}

quoin_status quoin_finder_set_filter(quoin_finder* finder,
                                     int (*filter)(void* context, int a, int b), void* context) {
  return with(finder, [&](quoin_finder& f) {
    if (filter == nullptr) return f.finder.set_filter({});
    f.finder.set_filter([=](int a, int b) { return filter(context, a, b) != 0; });
  });
}

quoin_status quoin_finder_set_reach(quoin_finder* finder, double reach) {
  return with(finder, [&](quoin_finder& f) { f.finder.set_reach(reach); });
}

quoin_status quoin_finder_set_body_reach(quoin_finder* finder, int handle, double reach) {
  return with(finder, [&](quoin_finder& f) { f.finder.set_reach(handle, reach); });
}

int quoin_finder_size(const quoin_finder* finder) {
  return finder == nullptr ? 0 : finder->finder.size();
}

int quoin_finder_threads(const quoin_finder* finder) {
  return finder == nullptr ? 0 : finder->finder.threads();
}

quoin_status quoin_finder_find(quoin_finder* finder) {
  return with(finder, [&](quoin_finder& f) {
    f.finder.find(finder->contacts);
    copy(finder->contacts, finder->points);
    copy(f.finder.pairs(), finder->pairs);
  });
}

quoin_status quoin_finder_contacts_of(quoin_finder* finder, const int* handles, int handle_count,
                                      quoin_contact_point* points, int* count) {
  return with(finder, [&](quoin_finder& f) {
    require(handle_count >= 0 && (handles != nullptr || handle_count == 0),
            "handles is null, or their number is negative");
    require_room(points, count);
    f.finder.contacts_of({handles, static_cast<std::size_t>(handle_count)}, finder->asked);
    return give(f.asked, points, *count);
  });
}

quoin_status quoin_finder_nearest_hit(quoin_finder* finder, const quoin_ray* ray,
                                      const quoin_query_filter* filter, quoin_body_hit* hit,
                                      int* hits) {
  return with(finder, [&](quoin_finder& f) {
    require(hit != nullptr && hits != nullptr, "an argument is null");
    const auto found = f.finder.nearest_hit(ray_of(ray), filter_of(filter));
    *hits = found.has_value() ? 1 : 0;
    if (found) *hit = to_c(*found);
  });
}

quoin_status quoin_finder_all_hits(quoin_finder* finder, const quoin_ray* ray,
                                   const quoin_query_filter* filter, quoin_body_hit* hits,
                                   int* count) {
  return with(finder, [&](quoin_finder& f) {
    require_room(hits, count);
    f.finder.all_hits(ray_of(ray), finder->hits, filter_of(filter));
    return give(f.hits, hits, *count);
  });
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
  return list(finder, &quoin_finder::points, count);
}

const quoin_pair* quoin_finder_pairs(const quoin_finder* finder, int* count) {
  return list(finder, &quoin_finder::pairs, count);
}

}  // extern "C"
