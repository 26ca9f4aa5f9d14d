/* Functions that are copied to where they are called, whatever the compiler thinks of their size: a call in a loop over
 * lanes would keep it from being vector code. Where it does not optimise, copies are but more to compile.
 * Knows nothing of what they compute. */
#ifndef GB_INLINE_H
#define GB_INLINE_H

#ifdef __OPTIMIZE__
#define GB_INLINE static inline __attribute__((always_inline))
#else
#define GB_INLINE static inline
#endif

#endif
