#ifndef QUOIN_GEOMETRY_C_H
#define QUOIN_GEOMETRY_C_H
/* quoin's geometry for C and, by ISO_C_BINDING, Fortran. SI units (m), world frame.
 *
 * No exception leaves these functions: those that can fail return a quoin_status. Results are
 * written into memory of the caller, or stay in a quoin_finder or quoin_batch until its next call.
 * These and a quoin_shape are memory of the library, given back by quoin_free_finder,
 * quoin_free_batch and quoin_free. One shape may be read by many threads at once, a finder or a
 * batch used by one at a time.
 *
 * Shapes, pairs, queries and batches are in the targets quoin::narrow_phase and quoin::geometry,
 * the finder in quoin::geometry alone; quoin::c is all of it in one shared library that shows
 * nothing else. */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* "major.minor.patch" */
const char* quoin_version(void);

typedef enum quoin_status {
  QUOIN_OK = 0,
  QUOIN_BAD_INPUT = 1, /* a null pointer, a number out of range, data that is no convex solid */
  QUOIN_NO_MEMORY = 2,
  QUOIN_NOT_CONVERGED = 3, /* the answer is the best found so far */
  QUOIN_TOO_MANY = 4,      /* the caller's list is too short: as many as fit were written; no
                              failure, it leaves no message */
  QUOIN_FAILED = 5         /* a fault of the library */
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
  QUOIN_OVERLAPPING = 2,
  QUOIN_PAIR_NOT_CONVERGED = 3
} quoin_pair_status;

/* ---- Shapes and where they stand ---- */

typedef struct quoin_shape quoin_shape;

/* x = translation + linear X, from a shape's own frame into the world. linear: by rows, a rotation
 * or, of a deforming body, R (I + strain); its determinant is positive. */
typedef struct quoin_placement {
  double linear[9];
  double translation[3]; /* m */
} quoin_placement;

/* A shape in its own frame. */
quoin_placement quoin_no_placement(void);

typedef struct quoin_body {
  const quoin_shape* shape;
  quoin_placement placement;
} quoin_body;

typedef struct quoin_feature {
  int kind;  /* quoin_feature_kind */
  int index; /* in the topology of its shape */
} quoin_feature;

/* Convex hull of `count` points (x, y, z after each other). Made shapes are written to `*made`, to
 * be given back by quoin_free. `message` (may be null) gets what is wrong, cut to message_size. */
quoin_status quoin_make_hull(const double* points, int count, quoin_shape** made, char* message,
                             size_t message_size);

/* Shape by its faces: face f has face_sizes[f] vertices, listed after each other in face_vertices,
 * either orientation throughout. */
quoin_status quoin_make_shape(const double* points, int count, const int* face_sizes,
                              int face_count, const int* face_vertices, quoin_shape** made,
                              char* message, size_t message_size);

/* A finder keeps the shapes of its bodies: they may be given back at any time. */
void quoin_free(quoin_shape* shape);

/* Number of vertices; 0 for null. The vertices of a hull are the points that span it. */
int quoin_vertex_count(const quoin_shape* shape);

/* For each vertex its number among the points given to quoin_make_*; room for all is needed. */
quoin_status quoin_input_indices(const quoin_shape* shape, int* indices);

/* The vertices of a feature in order; *count in: room, out: number of them. */
quoin_status quoin_feature_vertices(const quoin_shape* shape, quoin_feature feature, int* vertices,
                                    int* count);

/* For a code that moves vertices freely: new places of all of them (quoin_vertex_count), finite, in
 * the shape's own frame. Bodies of a finder keep the shape as it was when they were given it: see
 * quoin_finder_replace_shape. */
quoin_status quoin_set_vertices(quoin_shape* shape, const double* vertices);

/* ---- One pair ---- */

/* Where a search ended; start the next search of the same pair here. Fill with quoin_no_hint(). */
typedef struct quoin_hint {
  int vertices_a[4];
  int vertices_b[4];
  int face_a, face_b;
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
  int a, b;                           /* handles or names of the bodies; 0 and 1 of a single pair */
  quoin_feature feature_a, feature_b; /* vertex and face, or two edges: with a, b the point's key */
  int type;                           /* quoin_contact_type of the pair */
  int indeterminate;                  /* 1: the contact plane is one choice of several */
  int previous; /* finder, batch: its index in the list of the call before, -1: it was not there */
  double point_a[3], point_b[3];
  double normal[3]; /* unit, from A to B */
  double gap;       /* (point_b - point_a) . normal, m */
  double area;      /* share of the contact polygon, m2 */
} quoin_contact_point;

quoin_hint quoin_no_hint(void);

/* Nearest features. tolerance: contact length, m, 0 for the default. `hint` (may be null) is where
 * to start, and is brought up to date; it changes the speed, never the answer. */
quoin_status quoin_nearest_features(const quoin_body* a, const quoin_body* b, double tolerance,
                                    quoin_hint* hint, quoin_nearest* nearest);

/* The same, and all contact points up to `reach` (m) above the least gap. *count in: room in
 * `points`, out: number of contact points there are. */
quoin_status quoin_contact_points(const quoin_body* a, const quoin_body* b, double tolerance,
                                  double reach, quoin_hint* hint, quoin_nearest* nearest,
                                  quoin_contact_point* points, int* count);

/* ---- Lesser questions ---- */

/* *answer: 1 when the solids have a point in common, else 0. */
quoin_status quoin_overlap(const quoin_body* a, const quoin_body* b, int* answer);

/* *within: 1 when the gap is at most cut_off (m): then `nearest` is filled; else 0, found sooner.
 */
quoin_status quoin_distance_within(const quoin_body* a, const quoin_body* b, double cut_off,
                                   quoin_hint* hint, quoin_nearest* nearest, int* within);

typedef struct quoin_ray {
  double origin[3];    /* m */
  double direction[3]; /* not zero; need not be a unit vector */
  double length;       /* in units of the direction; may be infinite */
} quoin_ray;

typedef struct quoin_ray_hit {
  double s;         /* where the ray enters, in units of its direction; 0: it starts inside */
  double point[3];  /* m */
  double normal[3]; /* outward unit normal of the face; zero: it starts inside */
  int face;         /* -1: it starts inside */
} quoin_ray_hit;

/* *hits: 1 when the ray meets the solid: then `hit` is filled; else 0. */
quoin_status quoin_first_hit(const quoin_body* body, const quoin_ray* ray, quoin_ray_hit* hit,
                             int* hits);

/* *answer: 1 when a point lies in the solid or within `tolerance` (m) of all its faces, else 0. */
quoin_status quoin_contains(const quoin_body* body, const double* point, double tolerance,
                            int* answer);

/* ---- A batch: contacts of the caller's own candidate pairs ---- */

typedef enum quoin_pair_event {
  QUOIN_BEGIN = 0,
  QUOIN_PERSIST = 1,
  QUOIN_END = 2
} quoin_pair_event;

/* Two bodies in contact. The values of a pair that has ended are those of the last call before. */
typedef struct quoin_pair {
  int a, b;          /* handles or names of the bodies, a < b */
  int status;        /* quoin_pair_status */
  int type;          /* quoin_contact_type */
  int event;         /* quoin_pair_event */
  int indeterminate; /* 1: the contact plane is one choice of several */
  double gap;        /* m */
  double normal[3];  /* unit, from a to b */
  double area;       /* of the contact polygon, m2 */
  int first, count;  /* its points in the list; none when it has ended */
} quoin_pair;

/* What became of a body since the last call. */
typedef enum quoin_body_change {
  QUOIN_SAME = 0,    /* shape and placement are the same to the bit */
  QUOIN_MOVED = 1,   /* another placement */
  QUOIN_RESHAPED = 2 /* another shape, or other vertices */
} quoin_body_change;

/* Bodies in a row, and the pairs of them that may be in contact. Bodies that no pair names need
 * have neither shape nor placement: they are not looked at. */
typedef struct quoin_candidates {
  const quoin_body* bodies;
  int body_count;
  const int* names;   /* of the bodies in points and results, ascending; null: their places */
  const int* changes; /* quoin_body_change of each; null: all have moved */
  const int* pairs;   /* two places in the row for each pair, in any order */
  int pair_count;
} quoin_candidates;

/* Keeps what is known of each pair from call to call: that changes the speed, never the answer.
 * Used by one thread at a time. */
typedef struct quoin_batch quoin_batch;

/* reach: contact points are listed up to this gap, m. tolerance: contact length, m, 0 for the
 * default of each pair. To be given back by quoin_free_batch. */
quoin_status quoin_make_batch(double reach, double tolerance, quoin_batch** made, char* message,
                              size_t message_size);
void quoin_free_batch(quoin_batch* batch);

/* What was wrong with the last call of this batch that failed; "" when none has. */
const char* quoin_batch_message(const quoin_batch* batch);

quoin_status quoin_batch_set_reach(quoin_batch* batch, double reach);

/* Finds the contacts of all pairs; one given twice is answered once. The lists stay as they are
 * until the next call. */
quoin_status quoin_batch_find(quoin_batch* batch, const quoin_candidates* candidates);

/* A question by the way: what quoin_batch_find would list of these pairs alone, `previous` being
 * -1. *count in: room in `points`, out: number of contact points there are. The lists of the last
 * find stay as they are, and the next one goes on as though nobody had asked; `changes` are those
 * since the last find. */
quoin_status quoin_batch_contacts_of(quoin_batch* batch, const quoin_candidates* candidates,
                                     quoin_contact_point* points, int* count);

/* The contact points, sorted by key, and the pairs in contact or no longer so, by names. */
const quoin_contact_point* quoin_batch_points(const quoin_batch* batch, int* count);
const quoin_pair* quoin_batch_pairs(const quoin_batch* batch, int* count);

/* quoin_nearest_features of each pair, to the bit, in one call: for a code that asks for the same
 * pairs step after step. `hints` (quoin_no_hint() at first) and `nearest`: one a pair, in the order
 * of the pairs, one given twice has two. Names stand in messages and need not
 * ascend, changes are not read. On QUOIN_BAD_INPUT nothing has been written. */
quoin_status quoin_update_nearest_features(const quoin_candidates* candidates, double tolerance,
                                           quoin_hint* hints, quoin_nearest* nearest, char* message,
                                           size_t message_size);

/* ---- The finder: all contacts of a crowd of bodies ---- */

typedef struct quoin_finder quoin_finder;

typedef struct quoin_finder_options {
  double reach;     /* contact points are listed up to this gap, m; touching pairs always */
  double tolerance; /* contact length, m; 0 for the default of each pair */
  int threads;      /* any number gives the same bits */
} quoin_finder_options;

/* A pair is tested when each body's category has a bit of what the other collides with, and never
 * when both are idle (fixed, or known not to move). */
typedef struct quoin_body_options {
  uint32_t category;
  uint32_t collides_with;
  int idle; /* 0 or 1 */
} quoin_body_options;

/* To be given back by quoin_free_finder. */
quoin_status quoin_make_finder(const quoin_finder_options* options, quoin_finder** made,
                               char* message, size_t message_size);
void quoin_free_finder(quoin_finder* finder);

/* What was wrong with the last call of this finder that failed; "" when none has. */
const char* quoin_finder_message(const quoin_finder* finder);

/* Category 1, collides with all, not idle. */
quoin_body_options quoin_default_body_options(void);

/* Handles are given in ascending order from 0 on and never given again. options may be null. */
quoin_status quoin_finder_add(quoin_finder* finder, const quoin_body* body,
                              const quoin_body_options* options, int* handle);
/* Bodies that move as one under one handle h, such as a solid that is not convex; the placements of
 * the parts are in the compound's frame, `placement` (may be null) is its own. Part k has the
 * handle h + k, by which contacts and hits name it; parts are never tested against each other.
 * Move, remove, options, reach and contacts_of of h are of all parts. On failure no part is added.
 */
quoin_status quoin_finder_add_compound(quoin_finder* finder, const quoin_body* parts, int count,
                                       const quoin_placement* placement,
                                       const quoin_body_options* options, int* handle);
/* The compound that a body is a part of, and which; a body by itself is part 0 of itself. */
quoin_status quoin_finder_part_name(quoin_finder* finder, int handle, int* compound, int* part);
quoin_status quoin_finder_remove(quoin_finder* finder, int handle);
quoin_status quoin_finder_move(quoin_finder* finder, int handle, const quoin_placement* placement);
/* One of the same topology (the shape itself after quoin_set_vertices) has moved freely: its
 * contacts go on in the next list. Else they have no predecessors there. */
quoin_status quoin_finder_replace_shape(quoin_finder* finder, int handle, const quoin_shape* shape);
quoin_status quoin_finder_set_options(quoin_finder* finder, int handle,
                                      const quoin_body_options* options);

/* Asked for each pair of near bodies that the masks let pass: 0 leaves it out. Null: none is. */
quoin_status quoin_finder_set_filter(quoin_finder* finder,
                                     int (*filter)(void* context, int a, int b), void* context);
quoin_status quoin_finder_set_reach(quoin_finder* finder, double reach);
/* Of one body, m, 0 when it is added: the reach of a pair is the largest of those of its two bodies
 * and of the one for all. */
quoin_status quoin_finder_set_body_reach(quoin_finder* finder, int handle, double reach);

int quoin_finder_size(const quoin_finder* finder);    /* number of bodies; 0 for null */
int quoin_finder_threads(const quoin_finder* finder); /* fewer than asked for where refused */

/* Finds all contacts. The lists stay as they are until the next call. */
quoin_status quoin_finder_find(quoin_finder* finder);

/* A question by the way: what quoin_finder_find would list of those pairs alone that have a body of
 * `handles`, in any order, `previous` being -1. *count in: room in `points`, out: number of contact
 * points there are. The lists of the last find stay as they are, and the next one goes on as though
 * nobody had asked. */
quoin_status quoin_finder_contacts_of(quoin_finder* finder, const int* handles, int handle_count,
                                      quoin_contact_point* points, int* count);

/* Queries through the tree, of the bodies where they stand now; the next find goes on as though
 * nobody had asked. Looked at are bodies whose category has one of these bits and for which
 * `accepts` (may be null: all) is not 0. A filter may be null: all bodies. */
typedef struct quoin_query_filter {
  uint32_t categories;
  int (*accepts)(void* context, int handle);
  void* context;
} quoin_query_filter;

typedef struct quoin_body_hit {
  int handle;
  quoin_ray_hit hit;
} quoin_body_hit;

/* *hits: 1 when the ray meets a body: then `hit` is the one that it enters first, of several the
 * lowest handle; else 0. */
quoin_status quoin_finder_nearest_hit(quoin_finder* finder, const quoin_ray* ray,
                                      const quoin_query_filter* filter, quoin_body_hit* hit,
                                      int* hits);
/* All bodies that the ray enters, by s. *count in: room in `hits`, out: how many there are. */
quoin_status quoin_finder_all_hits(quoin_finder* finder, const quoin_ray* ray,
                                   const quoin_query_filter* filter, quoin_body_hit* hits,
                                   int* count);
/* Bodies whose axis-aligned boxes meet the one from min to max, m; of turned bodies the boxes are
 * up to half a diameter wider than the bodies. *count in: room in `handles`, out: how many there
 * are. */
quoin_status quoin_finder_bodies_in_box(quoin_finder* finder, const double* min, const double* max,
                                        const quoin_query_filter* filter, int* handles, int* count);
/* Bodies that contain a point within `tolerance`, m. *count as above. */
quoin_status quoin_finder_bodies_at(quoin_finder* finder, const double* point, double tolerance,
                                    const quoin_query_filter* filter, int* handles, int* count);

/* The contact points, sorted by key, and the pairs in contact or no longer so, by handles. */
const quoin_contact_point* quoin_finder_points(const quoin_finder* finder, int* count);
const quoin_pair* quoin_finder_pairs(const quoin_finder* finder, int* count);

#ifdef __cplusplus
}
#endif
#endif
