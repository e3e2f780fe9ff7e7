/* Whether the compiler has complex numbers, so that there are derivatives. Microsoft's has none. */
#ifndef CARDSFLOW_ALONG_SUPPORT_H
#define CARDSFLOW_ALONG_SUPPORT_H

#ifndef HAS_ALONG
#if defined(_MSC_VER) && !defined(__clang__)
#define HAS_ALONG 0
#else
#define HAS_ALONG 1
#endif
#endif

#endif
