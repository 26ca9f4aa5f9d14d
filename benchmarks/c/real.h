/* The number type: double for the peer, long double for the reference. */
#ifndef REAL_H
#define REAL_H

#include <float.h>
#include <tgmath.h>

#ifdef EXTENDED
typedef long double real;
#define REAL_EPS LDBL_EPSILON
#else
typedef double real;
#define REAL_EPS DBL_EPSILON
#endif

#endif
