#pragma once
/// What every x86-64 machine has; other machines have plain code instead. Internal.

#ifdef __SSE2__
#define QUOIN_SSE2
#include <emmintrin.h>
#endif
