#ifndef QUOIN_REFEREE_H
#define QUOIN_REFEREE_H
/* A contact library as a plug-in of `quoin referee`: a shared library that exports
 * quoin_referee_plugin(). SI units (m). The referee loads it in a process of its own, so it may
 * crash, hang, throw, print or take too much memory without harm; it is asked by one thread.
 *
 * What a library does not offer it leaves out of `offers`, and is not judged by it. */

#ifdef __cplusplus
extern "C" {
#endif

#define QUOIN_REFEREE_INTERFACE 1 /* number of this interface */

enum quoin_referee_offers {
  QUOIN_REFEREE_DISTANCE = 1,     /* gap of solids that are apart */
  QUOIN_REFEREE_DEPTH = 2,        /* gap of solids that overlap: minus the least translation that
                                     parts them */
  QUOIN_REFEREE_NORMAL = 4,       /* normal, of each gap that is offered */
  QUOIN_REFEREE_WITNESSES = 8,    /* point_a on A and point_b on B, of each gap that is offered */
  QUOIN_REFEREE_POINTS = 16,      /* contact points: the patch of solids that touch or overlap */
  QUOIN_REFEREE_APART = 32,       /* contact points of solids that are apart, too */
  QUOIN_REFEREE_AREAS = 64,       /* their areas */
  QUOIN_REFEREE_MEMORY = 128,     /* what was learned of a pair helps to answer it again */
  QUOIN_REFEREE_DEFORMED = 256,   /* placements that are no rotation */
  QUOIN_REFEREE_BOXES_ONLY = 512, /* answers boxes, and refuses other solids without blame */
  QUOIN_REFEREE_SIGN = 1024       /* tells overlap from distance alone: gap is 1 or -1 */
};

/* The convex hull of points (x, y, z after each other), in a frame of its own. Face f has
 * face_sizes[f] vertices, listed after each other in face_vertices, counter-clockwise from outside;
 * they cover the hull; none, where its faces are in doubt. box_half: half sides of a box that
 * follows the axes of the frame, about box_centre; zeros for other solids. */
typedef struct quoin_referee_solid {
  const double* points;
  int point_count;
  const int* face_sizes;
  int face_count;
  const int* face_vertices;
  double box_centre[3], box_half[3];
} quoin_referee_solid;

/* x = translation + linear X; linear by rows. */
typedef struct quoin_referee_placement {
  double linear[9];
  double translation[3];
} quoin_referee_placement;

typedef struct quoin_referee_answer {
  double gap;       /* distance, or minus the depth, m; or its sign alone (QUOIN_REFEREE_SIGN) */
  double normal[3]; /* unit, from A to B; zeros: none for this pair */
  double point_a[3], point_b[3];
} quoin_referee_answer;

typedef struct quoin_referee_point {
  double point_a[3], point_b[3]; /* one place for both, where the library has one */
  double gap;                    /* m, negative: overlap */
  double area;                   /* m2 */
} quoin_referee_point;

typedef enum quoin_referee_status {
  QUOIN_REFEREE_ANSWERED = 0,
  QUOIN_REFEREE_NO_ANSWER = 1, /* not offered for this pair: no fault */
  QUOIN_REFEREE_FAILED = 2     /* the library says that it failed: a fault */
} quoin_referee_status;

typedef struct quoin_referee_library {
  int interface; /* QUOIN_REFEREE_INTERFACE */
  const char* name;
  const char* version;
  int offers; /* quoin_referee_offers, added up */
  /* Error that the library promises or that its tolerance asks for, as a share of the larger
   * diameter; 0: rounding alone. */
  double promised_error;

  /* Null: the library refuses the solid. What `solid` points to lasts for the call alone. */
  void* (*make_solid)(const quoin_referee_solid* solid);
  void (*free_solid)(void* solid);
  /* What the library keeps of a pair from one question to the next; both null: nothing. */
  void* (*make_memory)(void);
  void (*free_memory)(void* memory);
  /* Placements first: set_placement moves a solid, and is timed with the question. */
  void (*set_placement)(void* solid, const quoin_referee_placement* placement);
  /* memory: null, or of this pair. Null: no gaps are offered. */
  quoin_referee_status (*ask)(void* a, void* b, void* memory, quoin_referee_answer* answer);
  /* Contact points; *count in: room (4096), out: number of them, at most that. Null: none are
   * offered. */
  quoin_referee_status (*list_points)(void* a, void* b, void* memory, quoin_referee_point* points,
                                      int* count);
} quoin_referee_library;

/* Library `index` (0, 1, …) of the plug-in, null behind the last one: a plug-in may hold several
 * settings of one library. What it points to lives as long as the plug-in. */
const quoin_referee_library* quoin_referee_plugin(int index);

#ifdef __cplusplus
}
#endif
#endif
