/* quoin as a plug-in of the referee, through its interface for C: hulls of points. */

#include <quoin/geometry_c.h>
#include <quoin/referee.h>
#include <stdlib.h>
#include <string.h>

static void* make_solid(const quoin_referee_solid* solid) {
  quoin_body* body = calloc(1, sizeof *body);
  quoin_shape* shape = NULL;
  if (body == NULL ||
      quoin_make_hull(solid->points, solid->point_count, &shape, NULL, 0) != QUOIN_OK) {
    free(body);
    return NULL;
  }
  body->shape = shape;
  body->placement = quoin_no_placement();
  return body;
}

static void free_solid(void* solid) {
  quoin_body* body = solid;
  quoin_free((quoin_shape*)body->shape);
  free(body);
}

static void* make_memory(void) {
  quoin_hint* hint = malloc(sizeof *hint);
  if (hint != NULL) {
    *hint = quoin_no_hint();
  }
  return hint;
}

static void set_placement(void* solid, const quoin_referee_placement* placement) {
  quoin_body* body = solid;
  memcpy(body->placement.linear, placement->linear, sizeof placement->linear);
  memcpy(body->placement.translation, placement->translation, sizeof placement->translation);
}

static quoin_referee_status ask(void* a, void* b, void* memory, quoin_referee_answer* answer) {
  quoin_nearest nearest;
  if (quoin_nearest_features(a, b, 0, memory, &nearest) != QUOIN_OK) {
    return QUOIN_REFEREE_FAILED;
  }
  answer->gap = nearest.gap;
  memcpy(answer->normal, nearest.normal, sizeof answer->normal);
  memcpy(answer->point_a, nearest.point_a, sizeof answer->point_a);
  memcpy(answer->point_b, nearest.point_b, sizeof answer->point_b);
  return QUOIN_REFEREE_ANSWERED;
}

enum { kMost = 4096 };

static quoin_referee_status list_points(void* a, void* b, void* memory, quoin_referee_point* points,
                                        int* count) {
  static quoin_contact_point found[kMost];
  quoin_nearest nearest;
  const int room = *count;
  *count = kMost;
  if (quoin_contact_points(a, b, 0, 0, memory, &nearest, found, count) != QUOIN_OK) {
    return QUOIN_REFEREE_FAILED;
  }
  for (int i = 0; i < *count && i < room; ++i) {
    memcpy(points[i].point_a, found[i].point_a, sizeof points[i].point_a);
    memcpy(points[i].point_b, found[i].point_b, sizeof points[i].point_b);
    points[i].gap = found[i].gap;
    points[i].area = found[i].area;
  }
  return QUOIN_REFEREE_ANSWERED;
}

const quoin_referee_library* quoin_referee_plugin(int index) {
  static quoin_referee_library library = {
      QUOIN_REFEREE_INTERFACE,
      "quoin C",
      QUOIN_VERSION,
      QUOIN_REFEREE_DISTANCE | QUOIN_REFEREE_DEPTH | QUOIN_REFEREE_NORMAL |
          QUOIN_REFEREE_WITNESSES | QUOIN_REFEREE_POINTS | QUOIN_REFEREE_APART |
          QUOIN_REFEREE_AREAS | QUOIN_REFEREE_MEMORY | QUOIN_REFEREE_DEFORMED,
      0.0,
      make_solid,
      free_solid,
      make_memory,
      free,
      set_placement,
      ask,
      list_points};
  return index == 0 ? &library : NULL;
}
