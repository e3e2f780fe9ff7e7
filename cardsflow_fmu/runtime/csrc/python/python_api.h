/* The functions of Python that the library uses, looked up in the running process.
 *
 * The library does not link to Python, so that it loads everywhere. All functions belong to the stable ABI,
 * so that one library supports all versions of Python. */
#ifndef PYTHON_API_H
#define PYTHON_API_H

#include "../platform/text.h"

#include <stddef.h>

typedef struct python_object python_object;
typedef ptrdiff_t python_ssize;

#define PYTHON_FUNCTIONS(F)                                                                         \
    F(int, Py_IsInitialized, (void))                                                                \
    F(const char *, Py_GetVersion, (void))                                                          \
    F(void, Py_DecRef, (python_object *))                                                           \
    F(int, PyGILState_Ensure, (void))                                                               \
    F(void, PyGILState_Release, (int))                                                              \
    F(void, PyErr_Clear, (void))                                                                    \
    F(void, PyErr_Fetch, (python_object **, python_object **, python_object **))                    \
    F(python_object *, PySys_GetObject, (const char *))                                             \
    F(python_object *, PyImport_ImportModule, (const char *))                                       \
    F(python_object *, PyObject_Str, (python_object *))                                             \
    F(int, PyObject_IsTrue, (python_object *))                                                      \
    F(python_object *, PyObject_GetAttrString, (python_object *, const char *))                     \
    F(python_object *, PyObject_CallNoArgs, (python_object *))                                      \
    F(python_object *, PyObject_CallFunctionObjArgs, (python_object *, ...))                        \
    F(python_object *, PyUnicode_DecodeFSDefault, (const char *))                                   \
    F(const char *, PyUnicode_AsUTF8AndSize, (python_object *, python_ssize *))                     \
    F(python_object *, PyBytes_FromStringAndSize, (const char *, python_ssize))                     \
    F(int, PyBytes_AsStringAndSize, (python_object *, char **, python_ssize *))                     \
    F(python_object *, PyByteArray_FromStringAndSize, (const char *, python_ssize))                 \
    F(char *, PyByteArray_AsString, (python_object *))                                              \
    F(python_object *, PyMemoryView_FromMemory, (char *, python_ssize, int))

struct python_api {
#define F(result, name, arguments) result (*name) arguments;
    PYTHON_FUNCTIONS(F)
#undef F
};

/* Fill in the functions. Return 0, or nonzero with a message about missing functions. */
int python_api_find(struct python_api *api, struct text *error);

#endif
