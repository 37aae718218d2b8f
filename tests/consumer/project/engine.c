/* Tables, each a compound of a top and two legs, fall straight on each other, through C; a ray from
 * above says how high they lie. */
#include <math.h>
#include <quoin/geometry_c.h>
#include <stdio.h>

enum { kTables = 3 };

static quoin_placement at(double x, double y, double z) {
  quoin_placement placement = quoin_no_placement();
  placement.translation[0] = x;
  placement.translation[1] = y;
  placement.translation[2] = z;
  return placement;
}

static quoin_shape* box(double x, double y, double z) {
  double corners[24];
  quoin_shape* made = NULL;
  for (int v = 0; v < 8; ++v) {
    corners[3 * v] = v & 1 ? 0.5 * x : -0.5 * x;
    corners[3 * v + 1] = v & 2 ? 0.5 * y : -0.5 * y;
    corners[3 * v + 2] = v & 4 ? 0.5 * z : -0.5 * z;
  }
  quoin_make_hull(corners, 8, &made, NULL, 0);
  return made;
}

int main(void) {
  const double step = 0.01, gravity = 9.81; /* s, m/s2 */
  const quoin_finder_options options = {0.02, 0.0, 1};
  quoin_finder* finder = NULL;
  if (quoin_make_finder(&options, &finder, NULL, 0) != QUOIN_OK) return 1;
  quoin_shape *floor = box(20, 20, 1), *top = box(2, 1, 0.2), *leg = box(0.2, 1, 0.8);
  const quoin_body ground = {floor, at(0, 0, -0.5)};
  const quoin_body parts[3] = {
      {top, at(0, 0, 0)}, {leg, at(-0.9, 0, -0.5)}, {leg, at(0.9, 0, -0.5)}};
  int under, handles[kTables], compound, part, count, hits = 0;
  double height[kTables], speed[kTables] = {0};
  quoin_finder_add(finder, &ground, NULL, &under);
  for (int k = 0; k < kTables; ++k) {
    height[k] = 1.2 + 1.3 * k;
    const quoin_placement place = at(0, 0, height[k]);
    if (quoin_finder_add_compound(finder, parts, 3, &place, NULL, &handles[k]) != QUOIN_OK)
      return 1;
  }
  quoin_free(floor);
  quoin_free(top);
  quoin_free(leg);

  for (int s = 0; s < 300; ++s) {
    if (quoin_finder_find(finder) != QUOIN_OK) return 1;
    const quoin_pair* pairs = quoin_finder_pairs(finder, &count);
    for (int k = 0; k < kTables; ++k) speed[k] -= gravity * step;
    for (int k = 0; k < kTables; ++k) { /* upwards: no faster down than to what lies below */
      for (int i = 0; i < count; ++i) {
        if (pairs[i].event == QUOIN_END) continue;
        quoin_finder_part_name(finder, pairs[i].b, &compound, &part);
        if (compound != handles[k]) continue;
        quoin_finder_part_name(finder, pairs[i].a, &compound, &part);
        const double below = k > 0 && compound == handles[k - 1] ? speed[k - 1] : 0.0;
        speed[k] = fmax(speed[k], below - pairs[i].gap / step);
      }
      height[k] += step * speed[k];
      const quoin_placement place = at(0, 0, height[k]);
      if (quoin_finder_move(finder, handles[k], &place) != QUOIN_OK) return 1;
    }
  }
  const quoin_ray ray = {{0, 0, 10}, {0, 0, -1}, HUGE_VAL};
  quoin_body_hit hit;
  if (quoin_finder_nearest_hit(finder, &ray, NULL, &hit, &hits) != QUOIN_OK || !hits) return 1;
  quoin_finder_part_name(finder, hit.handle, &compound, &part);
  printf("from above: part %d of compound %d at %.2f m\n", part, compound, hit.hit.point[2]);
  quoin_free_finder(finder);
  return 0;
}
