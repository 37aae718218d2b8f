#ifndef QUOIN_GEOMETRY_C_H
#define QUOIN_GEOMETRY_C_H
/* The query of quoin::narrow_phase for C and, by ISO_C_BINDING, Fortran. SI units (m), world frame.
 *
 * No exception leaves these functions: each returns a quoin_status. Results are written into memory
 * of the caller; only a quoin_polyhedron is memory of the library, given back by quoin_free. One
 * polyhedron may be read by many threads at once. */

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum quoin_status {
  QUOIN_OK = 0,
  QUOIN_BAD_INPUT = 1, /* a null pointer, a number out of range, data that is no convex solid */
  QUOIN_NO_MEMORY = 2,
  QUOIN_NOT_CONVERGED = 3, /* the answer is the best found so far */
  QUOIN_TOO_MANY = 4       /* the caller's list is too short: as many as fit were written */
} quoin_status;

typedef enum quoin_feature_kind {
  QUOIN_VERTEX = 0,
  QUOIN_EDGE = 1,
  QUOIN_FACE = 2
} quoin_feature_kind;

typedef enum quoin_contact_type {
  QUOIN_VERTEX_VERTEX = 0,
  QUOIN_VERTEX_EDGE = 1,
  QUOIN_VERTEX_FACE = 2,
  QUOIN_EDGE_EDGE_CROSSING = 3,
  QUOIN_EDGE_EDGE_PARALLEL = 4,
  QUOIN_EDGE_FACE = 5,
  QUOIN_FACE_FACE = 6
} quoin_contact_type;

typedef enum quoin_pair_status {
  QUOIN_SEPARATED = 0,
  QUOIN_TOUCHING = 1,
  QUOIN_OVERLAPPING = 2
} quoin_pair_status;

typedef struct quoin_polyhedron quoin_polyhedron;

typedef struct quoin_feature {
  int kind;  /* quoin_feature_kind */
  int index; /* in the topology of its polyhedron */
} quoin_feature;

/* Where a search ended; start the next search of the same pair here. Fill with quoin_no_hint(). */
typedef struct quoin_hint {
  int vertices_a[4];
  int vertices_b[4];
  double normal[3];
} quoin_hint;

typedef struct quoin_nearest {
  int status;        /* quoin_pair_status */
  int indeterminate; /* 1: the normal is one choice among several */
  int iterations;
  double gap;       /* distance, or minus the least translation that parts them, m */
  double normal[3]; /* unit, from A to B */
  double point_a[3], point_b[3];
  double residual_a, residual_b; /* certificate: reach beyond the witnesses along the normal, m */
  quoin_feature feature_a, feature_b;
} quoin_nearest;

typedef struct quoin_contact_point {
  quoin_feature feature_a, feature_b; /* vertex and face, or two edges: the key of the point */
  int type;                           /* quoin_contact_type of the pair */
  double point_a[3], point_b[3];
  double normal[3];
  double gap;  /* (point_b - point_a) . normal, m */
  double area; /* share of the contact polygon, m2 */
} quoin_contact_point;

/* Convex hull of `count` points (x, y, z after each other). Made solids are written to `*made`, to
 * be given back by quoin_free. `message` (may be null) gets what is wrong, cut to message_size. */
quoin_status quoin_make_hull(const double* points, int count, quoin_polyhedron** made,
                             char* message, size_t message_size);

/* Polyhedron by its faces: face f has face_sizes[f] vertices, listed after each other in
 * face_vertices, either orientation throughout. */
quoin_status quoin_make_polyhedron(const double* points, int count, const int* face_sizes,
                                   int face_count, const int* face_vertices,
                                   quoin_polyhedron** made, char* message, size_t message_size);

void quoin_free(quoin_polyhedron* polyhedron);

/* Number of vertices; 0 for null. The vertices of a hull are the points that span it. */
int quoin_vertex_count(const quoin_polyhedron* polyhedron);

/* For each vertex its number among the points given to quoin_make_*; room for all is needed. */
quoin_status quoin_input_indices(const quoin_polyhedron* polyhedron, int* indices);

/* The vertices of a feature in order; *count in: room, out: number of them. */
quoin_status quoin_feature_vertices(const quoin_polyhedron* polyhedron, quoin_feature feature,
                                    int* vertices, int* count);

/* Moves or deforms: new places of all vertices (quoin_vertex_count of them), finite. */
quoin_status quoin_set_vertices(quoin_polyhedron* polyhedron, const double* vertices);

quoin_hint quoin_no_hint(void);

/* Nearest features. tolerance: contact length, m, 0 for the default. `hint` (may be null) is where
 * to start, and is brought up to date; it changes the speed, never the answer. */
quoin_status quoin_nearest_features(const quoin_polyhedron* a, const quoin_polyhedron* b,
                                    double tolerance, quoin_hint* hint, quoin_nearest* nearest);

/* The same, and all contact points up to `reach` (m) above the least gap. *count in: room in
 * `points`, out: number of contact points there are. */
quoin_status quoin_contact_points(const quoin_polyhedron* a, const quoin_polyhedron* b,
                                  double tolerance, double reach, quoin_hint* hint,
                                  quoin_nearest* nearest, quoin_contact_point* points, int* count);

#ifdef __cplusplus
}
#endif
#endif
