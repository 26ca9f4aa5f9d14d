/* Functions that are copied to where they are called, whatever the compiler thinks of their size: a call in a loop over
 * lanes would keep it from being vector code. Where it does not optimise, copies are but more to compile. And functions
 * that stay apart: what is seldom run would take the registers of what always is.
 * Knows nothing of what they compute. */
#ifndef GB_INLINE_H
#define GB_INLINE_H

#ifdef __OPTIMIZE__
#define GB_INLINE static inline __attribute__((always_inline))
#else
#define GB_INLINE static inline
#endif

#if defined(__GNUC__) || defined(__clang__)
#define GB_OUT_OF_LINE static __attribute__((noinline))
#else
#define GB_OUT_OF_LINE static
#endif

#endif
