/* Plug-ins of the referee that misbehave, one for each BEHAVIOUR. */

#include <math.h>
#include <quoin/referee.h>
#include <stdio.h>
#include <stdlib.h>

enum behaviour {
  LIES, /* a gap of 1 m, always */
  CRASHES,
  HANGS,
  NAN_GAP,
  OVERLAPS_ONLY,    /* offers depths alone, and lies */
  REFUSES,          /* every solid */
  APART,            /* tells signs alone: every pair is apart */
  EXITS,            /* ends the process in the middle, as if all were well */
  ABORTS_UNLOADING, /* else lies */
  TALKS,            /* on standard output and standard error; else lies */
  EATS,             /* 1 TB of memory, and crashes where there is not so much */
  ENDLESS_POINTS,   /* lists more points than there is room for */
  POINTS_ONLY,      /* offers no gap; lists no point */
  OLD_INTERFACE,    /* is made for another interface */
  ENDLESS_LIBRARIES /* never returns null */
};

static void* make_solid(const quoin_referee_solid* solid) {
  return BEHAVIOUR == REFUSES || solid->point_count < 4 ? NULL : malloc(1);
}

static void set_placement(void* solid, const quoin_referee_placement* placement) {
  (void)solid;
  (void)placement;
}

static void eat(void) {
  for (int i = 0; i < 1024; ++i) {
    if (malloc((size_t)1 << 30) == NULL) { /* never touched: nobody else goes hungry */
      abort();
    }
  }
}

static void misbehave(void) {
  switch ((enum behaviour)BEHAVIOUR) {
    case CRASHES:
      abort();
    case HANGS:
      for (volatile int ends = 0; !ends;) {
      }
      break;
    case EXITS:
      exit(0);
    case TALKS:
      puts("bla");
      fputs("bla\n", stderr);
      break;
    case EATS:
      eat();
      break;
    default:
      break;
  }
}

static quoin_referee_status ask(void* a, void* b, void* memory, quoin_referee_answer* answer) {
  (void)a;
  (void)b;
  (void)memory;
  misbehave();
  answer->gap = BEHAVIOUR == NAN_GAP ? NAN : 1;
  return QUOIN_REFEREE_ANSWERED;
}

static quoin_referee_status list_points(void* a, void* b, void* memory, quoin_referee_point* points,
                                        int* count) {
  (void)a;
  (void)b;
  (void)memory;
  (void)points;
  *count = BEHAVIOUR == ENDLESS_POINTS ? 1 << 30 : 0;
  return QUOIN_REFEREE_ANSWERED;
}

static int offers(void) {
  switch ((enum behaviour)BEHAVIOUR) {
    case APART:
      return QUOIN_REFEREE_SIGN | QUOIN_REFEREE_DEFORMED;
    case OVERLAPS_ONLY:
      return QUOIN_REFEREE_DEPTH;
    case ENDLESS_POINTS:
    case POINTS_ONLY:
      return QUOIN_REFEREE_POINTS | QUOIN_REFEREE_DEFORMED;
    default:
      return QUOIN_REFEREE_DISTANCE | QUOIN_REFEREE_DEPTH | QUOIN_REFEREE_NORMAL |
             QUOIN_REFEREE_DEFORMED;
  }
}

#ifdef __GNUC__
__attribute__((destructor)) static void unload(void) {
  if (BEHAVIOUR == ABORTS_UNLOADING) {
    abort();
  }
}
#endif

const quoin_referee_library* quoin_referee_plugin(int index) {
  static quoin_referee_library library = {.interface = QUOIN_REFEREE_INTERFACE,
                                          .name = "bad",
                                          .version = "1",
                                          .make_solid = make_solid,
                                          .free_solid = free,
                                          .set_placement = set_placement,
                                          .list_points = list_points};
  library.offers = offers();
  library.ask = BEHAVIOUR == POINTS_ONLY ? NULL : ask;
  library.interface += BEHAVIOUR == OLD_INTERFACE;
  return index == 0 || BEHAVIOUR == ENDLESS_LIBRARIES ? &library : NULL;
}
