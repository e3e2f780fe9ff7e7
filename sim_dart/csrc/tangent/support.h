/* Whether derivatives are supported: they need complex numbers of double precision, which Microsoft's
   compiler does not have. */
#ifndef CARDSFLOW_TANGENT_SUPPORT_H
#define CARDSFLOW_TANGENT_SUPPORT_H

#ifndef HAS_CORE_TANGENT
#if defined(CARDSFLOW_FLOAT) || (defined(_MSC_VER) && !defined(__clang__))
#define HAS_CORE_TANGENT 0
#else
#define HAS_CORE_TANGENT 1
#endif
#endif

#endif
