/* The other end of names.h. */
#if defined(__clang__)
#pragma clang attribute pop
#endif
