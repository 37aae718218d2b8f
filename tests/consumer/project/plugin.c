/* A plug-in of the referee: Gilbert's algorithm for the distance of two sets of points, that is,
 * from a point of the difference B - A again and again to the point nearest to the origin between
 * it and the vertex that lies farthest towards the origin. Source: [Gilbert 1966] An iterative
 * procedure for computing the minimum of a quadratic form on a convex set, SIAM J. Control 4,
 * 61-80. */

#include <math.h>
#include <quoin/referee.h>
#include <stdlib.h>
#include <string.h>

typedef struct body {
  int count;
  quoin_referee_placement place;
  double points[]; /* in the frame of the solid */
} body;

static void* make_solid(const quoin_referee_solid* solid) {
  const size_t size = 3 * (size_t)solid->point_count * sizeof(double);
  body* made = calloc(1, sizeof *made + size);
  if (made != NULL) {
    made->count = solid->point_count;
    memcpy(made->points, solid->points, size);
  }
  return made;
}

static void set_placement(void* solid, const quoin_referee_placement* placement) {
  ((body*)solid)->place = *placement;
}

static double dot(const double* u, const double* v) {
  return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

/* The place of the point that lies farthest along sign * direction. */
static void support(const body* solid, const double* direction, double sign, double* place) {
  double best = -INFINITY;
  for (int i = 0; i < solid->count; ++i) {
    double at[3];
    for (int k = 0; k < 3; ++k) {
      at[k] = solid->place.translation[k] + dot(solid->place.linear + 3 * k, solid->points + 3 * i);
    }
    if (sign * dot(direction, at) > best) {
      best = sign * dot(direction, at);
      memcpy(place, at, sizeof at);
    }
  }
}

static quoin_referee_status ask(void* a, void* b, void* memory, quoin_referee_answer* answer) {
  double x[3], on_a[3], on_b[3];
  const double any[3] = {1, 0, 0};
  (void)memory;
  support(a, any, 1, on_a);
  support(b, any, -1, on_b);
  for (int k = 0; k < 3; ++k) {
    x[k] = on_b[k] - on_a[k];
  }
  for (int turn = 0; turn < 20000; ++turn) {
    double way[3];
    support(a, x, 1, on_a);
    support(b, x, -1, on_b);
    for (int k = 0; k < 3; ++k) {
      way[k] = on_b[k] - on_a[k] - x[k];
    }
    const double nearer = -dot(x, way), length = dot(way, way);
    if (nearer <= 1e-6 * dot(x, x)) {
      break;
    }
    const double part = nearer < length ? nearer / length : 1;
    for (int k = 0; k < 3; ++k) {
      x[k] += part * way[k];
    }
  }
  answer->gap = sqrt(dot(x, x));
  for (int k = 0; k < 3 && answer->gap > 0; ++k) {
    answer->normal[k] = x[k] / answer->gap;
  }
  return QUOIN_REFEREE_ANSWERED;
}

const quoin_referee_library* quoin_referee_plugin(int index) {
  static const quoin_referee_library library = {
      .interface = QUOIN_REFEREE_INTERFACE,
      .name = "Gilbert",
      .version = "1",
      .offers = QUOIN_REFEREE_DISTANCE | QUOIN_REFEREE_NORMAL | QUOIN_REFEREE_DEFORMED,
      .promised_error = 1e-2,
      .make_solid = make_solid,
      .free_solid = free,
      .set_placement = set_placement,
      .ask = ask};
  return index == 0 ? &library : NULL;
}
