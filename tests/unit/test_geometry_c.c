/* The C interface, used from C. */
#include <limits.h>
#include <math.h>
#include <quoin/geometry_c.h>
#include <stdio.h>
#include <string.h>

static int failures = 0;

#define CHECK(condition)                                             \
  do {                                                               \
    if (!(condition)) {                                              \
      printf("%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
      ++failures;                                                    \
    }                                                                \
  } while (0)

#define OK(call) CHECK((call) == QUOIN_OK)
#define BAD(call) CHECK((call) == QUOIN_BAD_INPUT)

static const int kFaceSizes[6] = {4, 4, 4, 4, 4, 4};
static const int kFaces[24] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4,
                               2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};

static void fill_cube(double* points, double x, double y, double z) {
  for (int i = 0; i < 8; ++i) {
    points[3 * i] = x + (i & 1);
    points[3 * i + 1] = y + ((i >> 1) & 1);
    points[3 * i + 2] = z + ((i >> 2) & 1);
  }
}

static quoin_shape* cube(double x, double y, double z) {
  double points[24];
  quoin_shape* made = NULL;
  char message[200];
  fill_cube(points, x, y, z);
  OK(quoin_make_shape(points, 8, kFaceSizes, 6, kFaces, &made, message, sizeof message));
  CHECK(message[0] == '\0');
  return made;
}

static quoin_body at_home(const quoin_shape* shape) {
  const quoin_body body = {shape, quoin_no_placement()};
  return body;
}

static quoin_placement at(double x, double y, double z) {
  quoin_placement placement = quoin_no_placement();
  const double translation[3] = {x, y, z};
  memcpy(placement.translation, translation, sizeof translation);
  return placement;
}

static void test_stacked_cubes(void) {
  quoin_shape* shape_a = cube(0, 0, 0);
  quoin_shape* shape_b = cube(0.5, 0.25, 1.125);
  const quoin_body body_a = at_home(shape_a), body_b = at_home(shape_b);
  const quoin_body *a = &body_a, *b = &body_b;
  quoin_nearest nearest;
  quoin_contact_point points[16];
  quoin_hint hint = quoin_no_hint();
  int count = 16;
  double area = 0;
  CHECK(quoin_vertex_count(shape_a) == 8);
  OK(quoin_nearest_features(a, b, 0.0, &hint, &nearest));
  CHECK(nearest.status == QUOIN_SEPARATED && nearest.gap == 0.125);
  CHECK(nearest.normal[0] == 0 && nearest.normal[1] == 0 && nearest.normal[2] == 1);
  OK(quoin_contact_points(a, b, 0.0, 0.01, &hint, &nearest, points, &count));
  CHECK(count == 4);
  for (int i = 0; i < count && i < 16; ++i) {
    CHECK(points[i].gap == 0.125 && points[i].type == QUOIN_FACE_FACE);
    area += points[i].area;
  }
  CHECK(fabs(area - 0.375) < 1e-15);
  count = -1;
  BAD(quoin_contact_points(a, b, 0.0, 0.01, NULL, &nearest, points, &count));
  count = 2;
  CHECK(quoin_contact_points(a, b, 0.0, 0.01, NULL, &nearest, points, &count) == QUOIN_TOO_MANY);
  CHECK(count == 4);

  double moved[24];
  fill_cube(moved, 0.5, 0.25, 0.75);
  OK(quoin_set_vertices(shape_b, moved));
  OK(quoin_nearest_features(a, b, 0.0, &hint, &nearest));
  CHECK(nearest.status == QUOIN_OVERLAPPING && nearest.gap == -0.25);
  moved[4] = NAN;
  BAD(quoin_set_vertices(shape_b, moved));
  quoin_free(shape_a);
  quoin_free(shape_b);
}

static void test_hull_and_features(void) {
  const double points[18] = {0, 0, 0, 1, 0, 0, 0.25, 0.25, 0.25, 0, 1, 0, 0, 0, 1, 0.1, 0.1, 0.1};
  quoin_shape* hull = NULL;
  int indices[6] = {-1, -1, -1, -1, -1, -1};
  int vertices[4];
  int count = 4;
  OK(quoin_make_hull(points, 6, &hull, NULL, 0));
  CHECK(quoin_vertex_count(hull) == 4);
  OK(quoin_input_indices(hull, indices));
  CHECK(indices[0] != 2 && indices[1] != 2 && indices[2] != 2 && indices[3] != 2);
  const quoin_feature face = {QUOIN_FACE, 0};
  CHECK(quoin_feature_vertices(hull, face, vertices, &count) == QUOIN_OK && count == 3);
  count = 1;
  CHECK(quoin_feature_vertices(hull, face, vertices, &count) == QUOIN_TOO_MANY && count == 3);
  const quoin_feature edge = {QUOIN_EDGE, 5};
  count = 4;
  CHECK(quoin_feature_vertices(hull, edge, vertices, &count) == QUOIN_OK && count == 2);
  const quoin_feature none = {QUOIN_EDGE, 6};
  BAD(quoin_feature_vertices(hull, none, vertices, &count));
  count = -1;
  CHECK(quoin_feature_vertices(hull, edge, vertices, &count) == QUOIN_BAD_INPUT && count == -1);
  quoin_free(hull);
}

static void test_bad_input(void) {
  double points[24];
  quoin_shape* made = NULL;
  quoin_nearest nearest;
  char message[80] = "";
  char tiny[5];
  int inverted[24];
  fill_cube(points, 0, 0, 0);
  BAD(quoin_make_hull(points, 3, &made, message, sizeof message));
  CHECK(strlen(message) > 0 && made == NULL);
  BAD(quoin_make_hull(points, 4, &made, tiny, sizeof tiny)); /* flat */
  CHECK(strlen(tiny) == 4);
  BAD(quoin_make_hull(points, -1, &made, NULL, 0));
  BAD(quoin_make_hull(points, INT_MAX, &made, message, sizeof message));
  CHECK(strstr(message, "2147483647 points, at most") != NULL);
  BAD(quoin_make_shape(points, INT_MAX, kFaceSizes, 6, kFaces, &made, NULL, 0));
  BAD(quoin_make_shape(points, 8, kFaceSizes, INT_MAX, kFaces, &made, NULL, 0));
  BAD(quoin_make_hull(NULL, 8, &made, NULL, 0));
  BAD(quoin_make_hull(points, 8, NULL, NULL, 0));
  points[5] = INFINITY;
  BAD(quoin_make_hull(points, 8, &made, NULL, 0));
  fill_cube(points, 0, 0, 0);
  BAD(quoin_make_shape(points, 8, kFaceSizes, 5, kFaces, &made, message,
                       sizeof message)); /* open */
  memcpy(inverted, kFaces, sizeof inverted);
  inverted[0] = 1, inverted[1] = 3, inverted[2] = 2, inverted[3] = 0;
  BAD(quoin_make_shape(points, 8, kFaceSizes, 6, inverted, &made, NULL,
                       0)); /* one face the wrong way round */
  CHECK(made == NULL);
  quoin_shape* shape = cube(0, 0, 0);
  quoin_body body = at_home(shape);
  const quoin_body* a = &body;
  BAD(quoin_nearest_features(a, NULL, 0.0, NULL, &nearest));
  BAD(quoin_nearest_features(a, a, -1.0, NULL, &nearest));
  BAD(quoin_nearest_features(a, a, NAN, NULL, &nearest));
  BAD(quoin_nearest_features(a, a, 0.0, NULL, NULL));
  body.placement.linear[4] = -1;
  BAD(quoin_nearest_features(a, a, 0.0, NULL, &nearest)); /* inside out */
  body = at_home(NULL);
  BAD(quoin_nearest_features(a, a, 0.0, NULL, &nearest));
  quoin_free(shape);
  quoin_free(NULL);
  CHECK(quoin_vertex_count(NULL) == 0);
}

static void test_hints_of_others(void) {
  quoin_shape* shape = cube(0, 0, 0);
  const quoin_body a = at_home(shape), b = {shape, at(0.5, 0.25, 1.25)};
  quoin_nearest nearest;
  quoin_hint hint = quoin_no_hint();
  hint.vertices_a[0] = 1000000; /* the hint of some other pair, or none at all */
  hint.vertices_b[2] = -7;
  hint.face_a = 99;
  hint.normal[1] = NAN;
  OK(quoin_nearest_features(&a, &b, 0.0, &hint, &nearest));
  CHECK(nearest.gap == 0.25 && hint.vertices_a[0] >= 0 && hint.vertices_a[0] < 8);
  quoin_free(shape);
}

static void test_queries(void) {
  quoin_shape* shape = cube(0, 0, 0);
  const quoin_body a = at_home(shape), b = {shape, at(1e6, 0.25, 0)};
  const double inside[3] = {1e6 + 0.5, 0.5, 0.5}, nowhere[3] = {NAN, 0, 0};
  quoin_ray ray = {{-1, 0.5, 0.5}, {2, 0, 0}, INFINITY};
  quoin_ray_hit hit;
  quoin_nearest nearest;
  int answer = -1;
  CHECK(quoin_overlap(&a, &b, &answer) == QUOIN_OK && answer == 0);
  CHECK(quoin_overlap(&b, &b, &answer) == QUOIN_OK && answer == 1);
  BAD(quoin_overlap(&a, &b, NULL));
  CHECK(quoin_distance_within(&a, &b, 1e3, NULL, &nearest, &answer) == QUOIN_OK && answer == 0);
  CHECK(quoin_distance_within(&a, &b, 1e7, NULL, &nearest, &answer) == QUOIN_OK && answer == 1);
  CHECK(nearest.gap == 1e6 - 1);
  CHECK(quoin_first_hit(&a, &ray, &hit, &answer) == QUOIN_OK && answer == 1);
  CHECK(hit.s == 0.5 && hit.normal[0] == -1 && hit.point[0] == 0);
  ray.length = 0.25;
  CHECK(quoin_first_hit(&a, &ray, &hit, &answer) == QUOIN_OK && answer == 0);
  ray.direction[0] = 0;
  BAD(quoin_first_hit(&a, &ray, &hit, &answer));
  CHECK(quoin_contains(&b, inside, 0.0, &answer) == QUOIN_OK && answer == 1);
  CHECK(quoin_contains(&a, inside, 0.0, &answer) == QUOIN_OK && answer == 0);
  CHECK(quoin_contains(&a, nowhere, 0.0, &answer) == QUOIN_OK && answer == 0);
  quoin_free(shape);
}

static int all_but_one_and_two(void* context, int a, int b) {
  ++*(int*)context;
  return a != 1 || b != 2;
}

static void test_finder(void) {
  const quoin_finder_options options = {1e-3, 0.0, 2};
  quoin_shape* shape = cube(0, 0, 0);
  quoin_body body = at_home(shape);
  quoin_body_options idle = quoin_default_body_options();
  quoin_finder* finder = NULL;
  int handle = -1, count = -1, asked = 0;
  OK(quoin_make_finder(&options, &finder, NULL, 0));
  CHECK(quoin_finder_threads(finder) == 2);
  for (int i = 0; i < 4; ++i) {
    body.placement = at(0, 0, i);
    CHECK(quoin_finder_add(finder, &body, NULL, &handle) == QUOIN_OK && handle == i);
  }
  quoin_free(shape); /* the finder keeps it */
  OK(quoin_finder_find(finder));
  const quoin_contact_point* points = quoin_finder_points(finder, &count);
  CHECK(count == 12 && points[4].a == 1 && points[4].b == 2 && points[4].previous == -1);
  const quoin_pair* pairs = quoin_finder_pairs(finder, &count);
  CHECK(count == 3 && pairs[1].event == QUOIN_BEGIN && pairs[1].type == QUOIN_FACE_FACE);
  CHECK(pairs[1].first == 4 && pairs[1].count == 4 && pairs[1].area == 1.0);
  quoin_contact_point some[8];
  const int handles[2] = {3, 0}, gone = 9;
  count = 8;
  CHECK(quoin_finder_contacts_of(finder, handles, 2, some, &count) == QUOIN_OK && count == 8);
  CHECK(some[0].a == 0 && some[7].b == 3 && some[7].previous == -1);
  count = 0;
  CHECK(quoin_finder_contacts_of(finder, handles, 1, NULL, &count) == QUOIN_TOO_MANY && count == 4);
  BAD(quoin_finder_contacts_of(finder, handles, 0, NULL, &count));
  count = -1;
  BAD(quoin_finder_contacts_of(finder, handles, 1, some, &count));
  BAD(quoin_finder_contacts_of(finder, &gone, 1, some, &count));
  BAD(quoin_finder_contacts_of(NULL, handles, 1, some, &count));
  CHECK(quoin_finder_points(finder, &count) == points && count == 12 && points[4].b == 2);
  CHECK(quoin_finder_remove(finder, 1) == QUOIN_OK && quoin_finder_size(finder) == 3);
  OK(quoin_finder_find(finder));
  points = quoin_finder_points(finder, &count);
  CHECK(count == 4 && points[0].a == 2 && points[0].b == 3 && points[0].previous == 8);
  pairs = quoin_finder_pairs(finder, &count);
  CHECK(count == 3 && pairs[0].event == QUOIN_END && pairs[2].event == QUOIN_PERSIST);
  BAD(quoin_finder_remove(finder, 1));
  CHECK(strcmp(quoin_finder_message(finder), "body 1 has been removed") == 0);
  idle.idle = 1;
  OK(quoin_finder_set_options(finder, 2, &idle));
  OK(quoin_finder_set_options(finder, 3, &idle));
  OK(quoin_finder_find(finder));
  quoin_finder_points(finder, &count);
  CHECK(count == 0);
  BAD(quoin_finder_set_options(finder, 3, NULL));
  idle.idle = 7;
  BAD(quoin_finder_set_options(finder, 3, &idle));
  BAD(quoin_finder_add(finder, &body, &idle, &handle));
  idle.idle = 0;
  OK(quoin_finder_set_options(finder, 3, &idle));
  OK(quoin_finder_set_filter(finder, all_but_one_and_two, &asked));
  CHECK(quoin_finder_find(finder) == QUOIN_OK && asked == 1);
  quoin_finder_points(finder, &count);
  CHECK(count == 4);
  body.placement = at(0, NAN, 0);
  BAD(quoin_finder_move(finder, 3, &body.placement));
  CHECK(strstr(quoin_finder_message(finder), "body 3: translation[1]") != NULL);
  BAD(quoin_finder_move(finder, 3, NULL));
  BAD(quoin_finder_add(finder, NULL, NULL, &handle));
  BAD(quoin_finder_replace_shape(finder, 3, NULL));
  BAD(quoin_finder_set_reach(finder, -1));
  BAD(quoin_finder_set_body_reach(finder, 3, -1));
  OK(quoin_finder_set_body_reach(finder, 3, 0.1));
  quoin_free_finder(finder);
  quoin_free_finder(NULL);
  CHECK(quoin_finder_find(NULL) == QUOIN_BAD_INPUT && quoin_finder_size(NULL) == 0);
  CHECK(quoin_finder_points(NULL, &count) == NULL && count == 0);
  BAD(quoin_make_finder(NULL, &finder, NULL, 0));
}

static int not_one(void* context, int handle) {
  ++*(int*)context;
  return handle != 1;
}

/* Three cubes in a row along x, and an L of two cubes above them. */
static void test_finder_queries(void) {
  const quoin_finder_options options = {1e-3, 0.0, 1};
  quoin_shape* shape = cube(0, 0, 0);
  quoin_body body = at_home(shape), parts[2];
  quoin_finder* finder = NULL;
  int handle = -1, count = 0, hit_count = 0, asked = 0, compound = -1, part = -1, handles[8];
  OK(quoin_make_finder(&options, &finder, NULL, 0));
  for (int i = 0; i < 3; ++i) {
    body.placement = at(2 * i, 0, 0);
    CHECK(quoin_finder_add(finder, &body, NULL, &handle) == QUOIN_OK && handle == i);
  }
  quoin_ray ray = {{-1, 0.5, 0.5}, {1, 0, 0}, HUGE_VAL};
  quoin_body_hit hit, hits[8];
  OK(quoin_finder_nearest_hit(finder, &ray, NULL, &hit, &hit_count));
  CHECK(hit_count == 1 && hit.handle == 0 && hit.hit.s == 1.0 && hit.hit.normal[0] == -1.0);
  quoin_query_filter filter = {UINT32_MAX, not_one, &asked};
  count = 8;
  OK(quoin_finder_all_hits(finder, &ray, &filter, hits, &count));
  CHECK(count == 2 && asked == 3 && hits[1].handle == 2 && hits[1].hit.s == 5.0);
  count = 1;
  CHECK(quoin_finder_all_hits(finder, &ray, NULL, hits, &count) == QUOIN_TOO_MANY && count == 3);
  BAD(quoin_finder_all_hits(finder, NULL, NULL, hits, &count));
  ray.direction[0] = 0;
  BAD(quoin_finder_nearest_hit(finder, &ray, NULL, &hit, &hit_count));
  const double low[3] = {0.5, 0.5, 0.5}, high[3] = {2.5, 0.75, 0.75};
  count = 8;
  OK(quoin_finder_bodies_in_box(finder, low, high, NULL, handles, &count));
  CHECK(count == 2 && handles[0] == 0 && handles[1] == 1);
  BAD(quoin_finder_bodies_in_box(finder, high, low, NULL, handles, &count));
  count = 8;
  OK(quoin_finder_bodies_at(finder, high, 0.0, &filter, handles, &count));
  CHECK(count == 0);
  parts[0].shape = parts[1].shape = shape;
  parts[0].placement = at(0, 0, 0);
  parts[1].placement = at(1, 0, 0);
  const quoin_placement above = at(0, 0, 1);
  OK(quoin_finder_add_compound(finder, parts, 2, &above, NULL, &handle));
  CHECK(handle == 3 && quoin_finder_size(finder) == 5);
  OK(quoin_finder_part_name(finder, 4, &compound, &part));
  CHECK(compound == 3 && part == 1);
  OK(quoin_finder_find(finder));
  const quoin_pair* pairs = quoin_finder_pairs(finder, &count);
  CHECK(count == 3 && pairs[0].a == 0 && pairs[0].b == 3); /* 0-3, 0-4 and 1-4, never 3-4 */
  CHECK(pairs[1].b == 4 && pairs[2].a == 1 && pairs[2].b == 4);
  BAD(quoin_finder_move(finder, 4, &above));
  OK(quoin_finder_move(finder, 3, &body.placement));
  BAD(quoin_finder_add_compound(finder, parts, 0, &above, NULL, &handle));
  CHECK(quoin_finder_remove(finder, 3) == QUOIN_OK && quoin_finder_size(finder) == 3);
  quoin_free_finder(finder);
  quoin_free(shape);
}

/* The caller's own candidate pairs. */
static void test_batch(void) {
  quoin_shape* shape = cube(0, 0, 0);
  quoin_body bodies[3];
  const int names[3] = {7, 9, 12}, backwards[3] = {9, 7, 12};
  const int pairs[8] = {2, 1, 0, 1, 1, 0, 0, 2}, none[2] = {0, 3};
  int changes[3] = {QUOIN_SAME, QUOIN_SAME, QUOIN_MOVED}, count = -1;
  quoin_candidates candidates = {bodies, 3, names, NULL, pairs, 4};
  quoin_batch* batch = NULL;
  for (int i = 0; i < 3; ++i) {
    bodies[i].shape = shape;
    bodies[i].placement = at(1e6, 0, i);
  }
  OK(quoin_make_batch(1e-3, 0.0, &batch, NULL, 0));
  OK(quoin_batch_find(batch, &candidates));
  const quoin_contact_point* points = quoin_batch_points(batch, &count);
  CHECK(count == 8 && points[0].a == 7 && points[7].b == 12 && points[7].previous == -1);
  const quoin_pair* found = quoin_batch_pairs(batch, &count);
  CHECK(count == 2 && found[1].a == 9 && found[1].event == QUOIN_BEGIN && found[1].area == 1.0);
  bodies[2].placement = at(1e6, 0, 3);
  candidates.changes = changes;
  OK(quoin_batch_find(batch, &candidates));
  points = quoin_batch_points(batch, &count);
  CHECK(count == 4 && points[3].previous == 3);
  found = quoin_batch_pairs(batch, &count);
  CHECK(count == 2 && found[0].event == QUOIN_PERSIST && found[1].event == QUOIN_END);
  quoin_contact_point asked[8];
  candidates.pair_count = 2; /* (2, 1) has ended */
  count = 3;
  CHECK(quoin_batch_contacts_of(batch, &candidates, asked, &count) == QUOIN_TOO_MANY && count == 4);
  count = 8;
  CHECK(quoin_batch_contacts_of(batch, &candidates, asked, &count) == QUOIN_OK && count == 4);
  CHECK(asked[3].a == 7 && asked[3].b == 9 && asked[3].previous == -1);
  BAD(quoin_batch_contacts_of(batch, &candidates, NULL, &count));
  count = -1;
  BAD(quoin_batch_contacts_of(batch, &candidates, asked, &count));
  BAD(quoin_batch_contacts_of(batch, NULL, asked, &count));
  BAD(quoin_batch_contacts_of(NULL, &candidates, asked, &count));
  candidates.pair_count = 4;
  CHECK(quoin_batch_points(batch, &count) == points && count == 4 && points[3].previous == 3);
  OK(quoin_batch_set_reach(batch, 1.5));
  OK(quoin_batch_find(batch, &candidates));
  quoin_batch_points(batch, &count);
  CHECK(count == 8);

  changes[1] = 5;
  BAD(quoin_batch_find(batch, &candidates));
  CHECK(strcmp(quoin_batch_message(batch), "change 5 is none of the three") == 0);
  candidates.changes = NULL;
  candidates.names = backwards;
  BAD(quoin_batch_find(batch, &candidates));
  candidates.names = names;
  candidates.pairs = none;
  candidates.pair_count = 1;
  BAD(quoin_batch_find(batch, &candidates));
  CHECK(strcmp(quoin_batch_message(batch), "pair 0 is (0, 3), must name two of 3 bodies") == 0);
  candidates.pairs = pairs;
  candidates.pair_count = 4;
  bodies[1].placement = at(0, NAN, 0);
  BAD(quoin_batch_find(batch, &candidates));
  CHECK(strstr(quoin_batch_message(batch), "body 9: translation[1]") != NULL);
  bodies[1].shape = NULL;
  count = 8;
  BAD(quoin_batch_find(batch, &candidates));
  BAD(quoin_batch_contacts_of(batch, &candidates, asked, &count));
  CHECK(strcmp(quoin_batch_message(batch), "body 9 or its shape is null") == 0);
  candidates.pairs = pairs + 6; /* (0, 2): nobody asks for body 1 */
  candidates.pair_count = 1;
  OK(quoin_batch_find(batch, &candidates));
  OK(quoin_batch_contacts_of(batch, &candidates, asked, &count));
  candidates.names = backwards;
  BAD(quoin_batch_contacts_of(batch, &candidates, asked, &count));
  CHECK(strcmp(quoin_batch_message(batch), "pair batch: body 1 is named 7, must be more than 9") ==
        0);
  candidates.names = names;
  candidates.body_count = candidates.pair_count = 0;
  OK(quoin_batch_find(batch, &candidates));
  BAD(quoin_batch_find(batch, NULL));
  BAD(quoin_batch_find(NULL, &candidates));
  BAD(quoin_batch_set_reach(batch, NAN));
  BAD(quoin_make_batch(-1.0, 0.0, &batch, NULL, 0));
  CHECK(quoin_batch_pairs(NULL, &count) == NULL && count == 0);
  quoin_free_batch(batch);
  quoin_free_batch(NULL);
  quoin_free(shape);
}

/* The answers of each pair alone, from wherever the hints start. */
static void test_distances(void) {
  quoin_shape* shape = cube(0, 0, 0);
  quoin_body bodies[6];
  int pairs[30], count = 0;
  const int same[2] = {3, 3};
  quoin_hint hints[15], hint;
  quoin_nearest nearest[15], alone;
  quoin_candidates candidates = {bodies, 6, NULL, NULL, pairs, 15};
  char message[200] = "";
  for (int i = 0; i < 6; ++i) bodies[i].shape = shape;
  for (int a = 0; a < 6; ++a) {
    for (int b = 0; b < a; ++b) {
      hints[count] = quoin_no_hint();
      pairs[2 * count] = a;
      pairs[2 * count++ + 1] = b;
    }
  }
  for (int step = 0; step < 3; ++step) {
    for (int i = 0; i < 6; ++i) bodies[i].placement = at(1.25 * i, 0.1 * step, 0.75 * (i % 3));
    if (step == 2) hints[4].face_a = 99; /* a hint of some other pair */
    OK(quoin_update_nearest_features(&candidates, 0.0, hints, nearest, message, sizeof message));
    for (int k = 0; k < count; ++k) {
      hint = quoin_no_hint();
      OK(quoin_nearest_features(bodies + pairs[2 * k], bodies + pairs[2 * k + 1], 0.0, &hint,
                                &alone));
      CHECK(nearest[k].gap == alone.gap && nearest[k].status == alone.status);
      CHECK(memcmp(nearest[k].normal, alone.normal, sizeof alone.normal) == 0);
      CHECK(memcmp(nearest[k].point_a, alone.point_a, sizeof alone.point_a) == 0);
      CHECK(memcmp(nearest[k].point_b, alone.point_b, sizeof alone.point_b) == 0);
      CHECK(nearest[k].residual_a == alone.residual_a && nearest[k].residual_b == alone.residual_b);
      CHECK(memcmp(&hints[k], &hint, sizeof hint) == 0);
    }
  }
  candidates.pairs = same;
  candidates.pair_count = 1;
  BAD(quoin_update_nearest_features(&candidates, 0.0, hints, nearest, message, sizeof message));
  CHECK(strcmp(message, "pair 0 is (3, 3), must name two of 6 bodies") == 0);
  BAD(quoin_update_nearest_features(&candidates, -1.0, hints, nearest, NULL, 0));
  BAD(quoin_update_nearest_features(&candidates, 0.0, NULL, nearest, NULL, 0));
  BAD(quoin_update_nearest_features(NULL, 0.0, hints, nearest, NULL, 0));
  candidates.pair_count = 0;
  OK(quoin_update_nearest_features(&candidates, 0.0, NULL, NULL, NULL, 0));
  quoin_free(shape);
}

/* More pairs than are answered together; then what is wrong with one: nothing has been written. */
static void test_distances_refused(void) {
  enum { kBodies = 600, kPairs = 2 * kBodies - 3 };
  static quoin_body bodies[kBodies];
  static quoin_hint hints[kPairs], old_hints[kPairs];
  static quoin_nearest nearest[kPairs], old_nearest[kPairs];
  static int pairs[2 * kPairs], names[kBodies];
  quoin_shape* shape = cube(0, 0, 0);
  quoin_candidates candidates = {bodies, kBodies, names, NULL, pairs, kPairs};
  char message[200] = "";
  for (int i = 0; i < kBodies; ++i) {
    bodies[i].shape = shape;
    bodies[i].placement = at(1.5 * i, 0, 0);
    names[i] = 10 * (kBodies - i);
  }
  for (int k = 0; k < kPairs; ++k) { /* neighbours, then those that are one farther */
    pairs[2 * k] = k % (kBodies - 1);
    pairs[2 * k + 1] = pairs[2 * k] + 1 + k / (kBodies - 1);
    hints[k] = quoin_no_hint();
  }
  OK(quoin_update_nearest_features(&candidates, 0.0, hints, nearest, message, sizeof message));
  for (int k = 0; k < kPairs; ++k) CHECK(nearest[k].gap == (k < kBodies - 1 ? 0.5 : 2.0));
  memcpy(old_hints, hints, sizeof hints);
  memcpy(old_nearest, nearest, sizeof nearest);
  for (int i = 0; i < kBodies; ++i) bodies[i].placement = at(2.0 * i, 0, 0);
  bodies[599].placement.translation[0] = NAN;
  BAD(quoin_update_nearest_features(&candidates, 0.0, hints, nearest, message, sizeof message));
  CHECK(strstr(message, "body 10: translation[0]") != NULL);
  bodies[599].shape = NULL;
  BAD(quoin_update_nearest_features(&candidates, 0.0, hints, nearest, message, sizeof message));
  CHECK(strcmp(message, "body 10 or its shape is null") == 0);
  CHECK(memcmp(old_hints, hints, sizeof hints) == 0);
  CHECK(memcmp(old_nearest, nearest, sizeof nearest) == 0);
  candidates.pair_count = kBodies - 2; /* nobody asks for the last one */
  OK(quoin_update_nearest_features(&candidates, 0.0, hints, nearest, message, sizeof message));
  CHECK(nearest[0].gap == 1.0 && message[0] == '\0');
  quoin_free(shape);
}

/* Vertices that move freely: bodies of a finder keep the shape that they were given. */
static void test_free_vertices(void) {
  const quoin_finder_options options = {1e-3, 0.0, 1};
  quoin_shape* shape = cube(0, 0, 0);
  quoin_shape* top = cube(0, 0, 1);
  const quoin_body a = at_home(shape), b = at_home(top);
  quoin_finder* finder = NULL;
  double raised[24];
  int handle, count;
  OK(quoin_make_finder(&options, &finder, NULL, 0));
  OK(quoin_finder_add(finder, &a, NULL, &handle));
  OK(quoin_finder_add(finder, &b, NULL, &handle));
  OK(quoin_finder_find(finder));
  fill_cube(raised, 0, 0, 1.0001);
  OK(quoin_set_vertices(top, raised));
  OK(quoin_finder_replace_shape(finder, handle, top));
  OK(quoin_finder_find(finder));
  CHECK(quoin_finder_points(finder, &count)[3].previous == 3);
  fill_cube(raised, 0, 0, 1.5);
  OK(quoin_set_vertices(top, raised));
  OK(quoin_finder_find(finder));
  quoin_finder_points(finder, &count);
  CHECK(count == 4);
  OK(quoin_finder_replace_shape(finder, handle, top));
  OK(quoin_finder_find(finder));
  quoin_finder_points(finder, &count);
  CHECK(count == 0);
  raised[0] = 1e31;
  BAD(quoin_set_vertices(top, raised));
  quoin_free(shape);
  quoin_free(top);
  quoin_free_finder(finder);
}

int main(void) {
  test_stacked_cubes();
  test_hull_and_features();
  test_bad_input();
  test_hints_of_others();
  test_queries();
  test_finder();
  test_finder_queries();
  test_batch();
  test_distances();
  test_distances_refused();
  test_free_vertices();
  CHECK(strchr(quoin_version(), '.') != NULL);
  if (failures == 0) {
    printf("all passed\n");
  }
  return failures == 0 ? 0 : 1;
}
