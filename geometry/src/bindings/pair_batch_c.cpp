#include <quoin/geometry/pair_batch.hpp>

#include "bindings/c_values.hpp"
#include "finder/placed_box.hpp"

namespace geometry = quoin::geometry;

struct quoin_batch {
  explicit quoin_batch(const geometry::ContactOptions& options) : batch(options) {}

  geometry::PairBatch batch;
  std::vector<geometry::BlockPair> candidates;
  std::vector<geometry::BodyChange> changes;
  std::vector<geometry::ContactPoint> contacts, asked;
  std::vector<quoin_contact_point> points;
  std::vector<quoin_pair> pairs;
  char message[256] = "";
};

namespace {

using namespace quoin::geometry::bindings;  // NOLINT: private to this file

static_assert(static_cast<int>(geometry::BodyChange::Shape) == QUOIN_RESHAPED);

/// The body was checked.
geometry::Body body_in_row(const void* owner, int index) {
  const quoin_body& body = static_cast<const quoin_body*>(owner)[index];
  return {*body.shape->solid, placement_of(body.placement)};
}

template <class T>
std::span<const T> row(const T* values, int count) {
  if (values == nullptr) return {};
  return {values, static_cast<std::size_t>(count)};
}

void check_lists(const quoin_candidates* given) {
  require(given != nullptr && given->body_count >= 0 && given->pair_count >= 0,
          "candidates is null, or a count is negative");
  require(given->bodies != nullptr || given->body_count == 0, "bodies is null");
  require(given->pairs != nullptr || given->pair_count == 0, "pairs is null");
}

geometry::BlockPair pair_of(const quoin_candidates& given, std::size_t k) {
  return {given.pairs[2 * k], given.pairs[2 * k + 1]};
}

/// The pairs, and of the bodies those that they name.
void check(const quoin_candidates* given) {
  check_lists(given);
  const auto count = static_cast<std::size_t>(given->pair_count);
  for (std::size_t k = 0; k < count; ++k)
    geometry::check_pair(k, pair_of(*given, k), given->body_count);
  for (std::size_t k = 0; k < count; ++k)
    for (const int i : {pair_of(*given, k).a, pair_of(*given, k).b})
      geometry::bindings::check(given->bodies + i, given->names == nullptr ? i : given->names[i]);
}

geometry::BodyChange change_of(int change) {
  if (change < QUOIN_SAME || change > QUOIN_RESHAPED)
    throw geometry::InputError("change " + std::to_string(change) + " is none of the three");
  return static_cast<geometry::BodyChange>(change);
}

/// Into the batch: changes and pairs, too.
geometry::BodySource read(const quoin_candidates& given, quoin_batch& batch) {
  batch.changes.clear();
  for (const int change : row(given.changes, given.body_count))
    batch.changes.push_back(change_of(change));
  batch.candidates.clear();
  for (std::size_t k = 0; k < static_cast<std::size_t>(given.pair_count); ++k)
    batch.candidates.push_back(pair_of(given, k));
  geometry::BodySource source;
  source.owner = given.bodies;
  source.body = body_in_row;
  source.count = given.body_count;
  source.names = row(given.names, given.body_count);
  source.changes = batch.changes;
  return source;
}

void find(quoin_batch& batch, const quoin_candidates& given) {
  const geometry::BodySource bodies = read(given, batch);
  batch.batch.find(bodies, batch.candidates, batch.contacts);
  copy(batch.contacts, batch.points);
  copy(batch.batch.pairs(), batch.pairs);
}

quoin_status update_all(const quoin_candidates& given, double tolerance, quoin_hint* hints,
                        quoin_nearest* nearest) {
  quoin_status status = QUOIN_OK;
  for (std::size_t k = 0; k < static_cast<std::size_t>(given.pair_count); ++k) {
    const auto [i, j] = pair_of(given, k);
    const geometry::Body a = body_in_row(given.bodies, i), b = body_in_row(given.bodies, j);
    const geometry::NearestFeatures found =
        nearest_features(a, b, {.tolerance = tolerance}, from_c(hints + k, a, b));
    if (give(found, hints + k, nearest + k) != QUOIN_OK) status = QUOIN_NOT_CONVERGED;
  }
  return status;
}

}  // namespace

extern "C" {

quoin_status quoin_make_batch(double reach, double tolerance, quoin_batch** made, char* message,
                              size_t message_size) {
  say("", message, message_size);
  return guarded(
      [&] {
        require(made != nullptr, "made is null");
        *made = new quoin_batch({.tolerance = tolerance, .reach = reach});
      },
      message, message_size);
}

void quoin_free_batch(quoin_batch* batch) { delete batch; }

const char* quoin_batch_message(const quoin_batch* batch) {
  return batch == nullptr ? "" : batch->message;
}

quoin_status quoin_batch_set_reach(quoin_batch* batch, double reach) {
  return with(batch, [&](quoin_batch& b) { b.batch.set_reach(reach); });
}

quoin_status quoin_batch_find(quoin_batch* batch, const quoin_candidates* candidates) {
  return with(batch, [&](quoin_batch& b) {
    check(candidates);
    find(b, *candidates);
  });
}

quoin_status quoin_batch_contacts_of(quoin_batch* batch, const quoin_candidates* candidates,
                                     quoin_contact_point* points, int* count) {
  return with(batch, [&](quoin_batch& b) {
    check(candidates);
    require_room(points, count);
    const geometry::BodySource bodies = read(*candidates, b);
    geometry::check_names(bodies.names);
    b.batch.contacts_of(bodies, b.candidates, b.asked);
    return give(b.asked, points, *count);
  });
}

quoin_status quoin_update_nearest_features(const quoin_candidates* candidates, double tolerance,
                                           quoin_hint* hints, quoin_nearest* nearest, char* message,
                                           size_t message_size) {
  say("", message, message_size);
  const auto run = [&] {
    check(candidates);
    require((hints != nullptr && nearest != nullptr) || candidates->pair_count == 0,
            "hints or nearest is null");
    geometry::require_length(tolerance, "tolerance");
    return update_all(*candidates, tolerance, hints, nearest);
  };
  return guarded(run, message, message_size);
}

const quoin_contact_point* quoin_batch_points(const quoin_batch* batch, int* count) {
  return list(batch, &quoin_batch::points, count);
}

const quoin_pair* quoin_batch_pairs(const quoin_batch* batch, int* count) {
  return list(batch, &quoin_batch::pairs, count);
}

}  // extern "C"
