/* The part of <math.h> that the core and the control laws use, for machines without a C library.

   All functions are exact or, as the square root, rounded as IEEE 754 specifies, so that results do not
   depend on the implementation. `sqrt` is an instruction of the processor. If the processor does not have
   it, the compiler's library must provide it: compile with -fno-math-errno. */
#ifndef CARDSFLOW_FREESTANDING_MATH_H
#define CARDSFLOW_FREESTANDING_MATH_H

#define NAN __builtin_nanf("")
#define INFINITY __builtin_inff()

#define isfinite(x) __builtin_isfinite(x)
#define isnan(x) __builtin_isnan(x)
#define isinf(x) __builtin_isinf(x)
#define signbit(x) __builtin_signbit(x)
#define fabs(x) __builtin_fabs(x)
#define fabsf(x) __builtin_fabsf(x)
#define sqrtf(x) __builtin_sqrtf(x)

double sqrt(double x);
double fmod(double x, double y);
double ceil(double x);
double round(double x);
float fmodf(float x, float y);
float ceilf(float x);
float roundf(float x);

#endif
