/* Functions that Python calls with ctypes. */
#ifndef RUN_EXPORT_H
#define RUN_EXPORT_H

#if defined(_WIN32)
#define RUN_API __declspec(dllexport)
#else
#define RUN_API __attribute__((visibility("default")))
#endif

#endif
