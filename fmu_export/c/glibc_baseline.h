/* Asks for the oldest versions of the functions of libm that newer ones of glibc have renewed, so that a library built
 * on a new machine runs on old ones. They compute the same values and differ in how they set errno. Included ahead of
 * every source where glibc on x86-64 is the target; elsewhere nothing of it is needed. */
#ifndef GB_GLIBC_BASELINE_H
#define GB_GLIBC_BASELINE_H

#include <features.h>

#if defined(__GLIBC__) && defined(__x86_64__) && !defined(__ILP32__)
__asm__(".symver exp,exp@GLIBC_2.2.5");
__asm__(".symver exp2,exp2@GLIBC_2.2.5");
__asm__(".symver log,log@GLIBC_2.2.5");
__asm__(".symver log2,log2@GLIBC_2.2.5");
__asm__(".symver pow,pow@GLIBC_2.2.5");
__asm__(".symver fmod,fmod@GLIBC_2.2.5");
__asm__(".symver hypot,hypot@GLIBC_2.2.5");
#endif

#endif
