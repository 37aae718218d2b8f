/* Plug-ins of the referee that misbehave. BEHAVIOUR: 0 lies (a gap of 1 m), 1 crashes, 2 never
 * ends, 3 returns NaN, 4 lies about overlap alone, 5 refuses every solid, 6 says of every pair
 * that it is apart, and no more. */

#include <math.h>
#include <quoin/referee.h>
#include <stdlib.h>

static void* make_solid(const quoin_referee_solid* solid) {
  return BEHAVIOUR == 5 || solid->point_count < 4 ? NULL : malloc(1);
}

static void set_placement(void* solid, const quoin_referee_placement* placement) {
  (void)solid;
  (void)placement;
}

static quoin_referee_status ask(void* a, void* b, void* memory, quoin_referee_answer* answer) {
  (void)a;
  (void)b;
  (void)memory;
  if (BEHAVIOUR == 1) {
    abort();
  }
  for (volatile int ends = 0; BEHAVIOUR == 2 && !ends;) {
  }
  answer->gap = BEHAVIOUR == 3 ? NAN : 1;
  return QUOIN_REFEREE_ANSWERED;
}

const quoin_referee_library* quoin_referee_plugin(int index) {
  static quoin_referee_library library = {
      QUOIN_REFEREE_INTERFACE,
      "bad",
      "1",
      BEHAVIOUR == 6   ? QUOIN_REFEREE_SIGN | QUOIN_REFEREE_DEFORMED
      : BEHAVIOUR == 4 ? QUOIN_REFEREE_DEPTH
                       : QUOIN_REFEREE_DISTANCE | QUOIN_REFEREE_DEPTH | QUOIN_REFEREE_NORMAL |
                             QUOIN_REFEREE_DEFORMED,
      0,
      make_solid,
      free,
      NULL,
      NULL,
      set_placement,
      ask,
      NULL};
  return index == 0 ? &library : NULL;
}
