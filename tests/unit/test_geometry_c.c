/* The C interface, used from C. */
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

static quoin_polyhedron* cube(double x, double y, double z) {
  double points[24];
  quoin_polyhedron* made = NULL;
  char message[200];
  fill_cube(points, x, y, z);
  CHECK(quoin_make_polyhedron(points, 8, kFaceSizes, 6, kFaces, &made, message, sizeof message) ==
        QUOIN_OK);
  CHECK(message[0] == '\0');
  return made;
}

static void test_stacked_cubes(void) {
  quoin_polyhedron* a = cube(0, 0, 0);
  quoin_polyhedron* b = cube(0.5, 0.25, 1.125);
  quoin_nearest nearest;
  quoin_contact_point points[16];
  quoin_hint hint = quoin_no_hint();
  int count = 16;
  double area = 0;
  CHECK(quoin_vertex_count(a) == 8);
  CHECK(quoin_nearest_features(a, b, 0.0, &hint, &nearest) == QUOIN_OK);
  CHECK(nearest.status == QUOIN_SEPARATED && nearest.gap == 0.125);
  CHECK(nearest.normal[0] == 0 && nearest.normal[1] == 0 && nearest.normal[2] == 1);
  CHECK(quoin_contact_points(a, b, 0.0, 0.01, &hint, &nearest, points, &count) == QUOIN_OK);
  CHECK(count == 4);
  for (int i = 0; i < count && i < 16; ++i) {
    CHECK(points[i].gap == 0.125 && points[i].type == QUOIN_FACE_FACE);
    area += points[i].area;
  }
  CHECK(fabs(area - 0.375) < 1e-15);
  count = 2;
  CHECK(quoin_contact_points(a, b, 0.0, 0.01, NULL, &nearest, points, &count) == QUOIN_TOO_MANY);
  CHECK(count == 4);

  double moved[24];
  fill_cube(moved, 0.5, 0.25, 0.75);
  CHECK(quoin_set_vertices(b, moved) == QUOIN_OK);
  CHECK(quoin_nearest_features(a, b, 0.0, &hint, &nearest) == QUOIN_OK);
  CHECK(nearest.status == QUOIN_OVERLAPPING && nearest.gap == -0.25);
  moved[4] = NAN;
  CHECK(quoin_set_vertices(b, moved) == QUOIN_BAD_INPUT);
  quoin_free(a);
  quoin_free(b);
}

static void test_hull_and_features(void) {
  const double points[18] = {0, 0, 0, 1, 0, 0, 0.25, 0.25, 0.25, 0, 1, 0, 0, 0, 1, 0.1, 0.1, 0.1};
  quoin_polyhedron* hull = NULL;
  int indices[6] = {-1, -1, -1, -1, -1, -1};
  int vertices[4];
  int count = 4;
  CHECK(quoin_make_hull(points, 6, &hull, NULL, 0) == QUOIN_OK);
  CHECK(quoin_vertex_count(hull) == 4);
  CHECK(quoin_input_indices(hull, indices) == QUOIN_OK);
  CHECK(indices[0] != 2 && indices[1] != 2 && indices[2] != 2 && indices[3] != 2);
  const quoin_feature face = {QUOIN_FACE, 0};
  CHECK(quoin_feature_vertices(hull, face, vertices, &count) == QUOIN_OK && count == 3);
  count = 1;
  CHECK(quoin_feature_vertices(hull, face, vertices, &count) == QUOIN_TOO_MANY && count == 3);
  const quoin_feature edge = {QUOIN_EDGE, 5};
  count = 4;
  CHECK(quoin_feature_vertices(hull, edge, vertices, &count) == QUOIN_OK && count == 2);
  const quoin_feature none = {QUOIN_EDGE, 6};
  CHECK(quoin_feature_vertices(hull, none, vertices, &count) == QUOIN_BAD_INPUT);
  quoin_free(hull);
}

static void test_bad_input(void) {
  double points[24];
  quoin_polyhedron* made = NULL;
  quoin_nearest nearest;
  char message[80] = "";
  char tiny[5];
  int inverted[24];
  fill_cube(points, 0, 0, 0);
  CHECK(quoin_make_hull(points, 3, &made, message, sizeof message) == QUOIN_BAD_INPUT);
  CHECK(strlen(message) > 0 && made == NULL);
  CHECK(quoin_make_hull(points, 4, &made, tiny, sizeof tiny) == QUOIN_BAD_INPUT); /* flat */
  CHECK(strlen(tiny) == 4);
  CHECK(quoin_make_hull(points, -1, &made, NULL, 0) == QUOIN_BAD_INPUT);
  CHECK(quoin_make_hull(NULL, 8, &made, NULL, 0) == QUOIN_BAD_INPUT);
  CHECK(quoin_make_hull(points, 8, NULL, NULL, 0) == QUOIN_BAD_INPUT);
  points[5] = INFINITY;
  CHECK(quoin_make_hull(points, 8, &made, NULL, 0) == QUOIN_BAD_INPUT);
  fill_cube(points, 0, 0, 0);
  CHECK(quoin_make_polyhedron(points, 8, kFaceSizes, 5, kFaces, &made, message, sizeof message) ==
        QUOIN_BAD_INPUT); /* open */
  memcpy(inverted, kFaces, sizeof inverted);
  inverted[0] = 1, inverted[1] = 3, inverted[2] = 2, inverted[3] = 0;
  CHECK(quoin_make_polyhedron(points, 8, kFaceSizes, 6, inverted, &made, NULL, 0) ==
        QUOIN_BAD_INPUT); /* one face the wrong way round */
  CHECK(made == NULL);
  quoin_polyhedron* a = cube(0, 0, 0);
  CHECK(quoin_nearest_features(a, NULL, 0.0, NULL, &nearest) == QUOIN_BAD_INPUT);
  CHECK(quoin_nearest_features(a, a, -1.0, NULL, &nearest) == QUOIN_BAD_INPUT);
  CHECK(quoin_nearest_features(a, a, NAN, NULL, &nearest) == QUOIN_BAD_INPUT);
  CHECK(quoin_nearest_features(a, a, 0.0, NULL, NULL) == QUOIN_BAD_INPUT);
  quoin_free(a);
  quoin_free(NULL);
  CHECK(quoin_vertex_count(NULL) == 0);
}

int main(void) {
  test_stacked_cubes();
  test_hull_and_features();
  test_bad_input();
  if (failures == 0) {
    printf("all passed\n");
  }
  return failures == 0 ? 0 : 1;
}
