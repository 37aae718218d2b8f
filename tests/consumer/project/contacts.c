/* The C interface: two boxes of one shape, one on the other, then apart. */
#include <quoin/geometry_c.h>
#include <stdio.h>

int main(void) {
  const double corners[24] = {0, 0, 0, 2, 0, 0, 0, 1, 0, 2, 1, 0,
                              0, 0, 1, 2, 0, 1, 0, 1, 1, 2, 1, 1};
  const quoin_finder_options options = {1e-3, 0.0, 1};
  quoin_shape* brick = NULL;
  quoin_finder* finder = NULL;
  char message[200];
  int lower, upper, count;
  if (quoin_make_hull(corners, 8, &brick, message, sizeof message) != QUOIN_OK ||
      quoin_make_finder(&options, &finder, message, sizeof message) != QUOIN_OK) {
    fprintf(stderr, "%s\n", message);
    return 1;
  }
  quoin_body body = {brick, quoin_no_placement()};
  quoin_finder_add(finder, &body, NULL, &lower);
  body.placement.translation[0] = 1;
  body.placement.translation[2] = 1;
  quoin_finder_add(finder, &body, NULL, &upper);
  quoin_free(brick);
  if (quoin_finder_find(finder) != QUOIN_OK) return 1;
  const quoin_contact_point* points = quoin_finder_points(finder, &count);
  for (int i = 0; i < count; ++i) {
    printf("%d on %d: gap %g m, %g m2\n", points[i].b, points[i].a, points[i].gap, points[i].area);
  }
  body.placement.translation[2] = 3;
  quoin_finder_move(finder, upper, &body.placement);
  if (quoin_finder_find(finder) != QUOIN_OK) return 1;
  const quoin_pair* pairs = quoin_finder_pairs(finder, &count);
  printf("quoin %s: %d pair%s\n", quoin_version(), count,
         count == 1 && pairs[0].event == QUOIN_END ? " has ended" : "s");
  quoin_free_finder(finder);
  return 0;
}
