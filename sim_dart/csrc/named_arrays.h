/* Handles whose arrays have names and lie in the memory after the handle. A list contains ARRAY(name, length)
   for each array, with its number of reals:

     struct handle { size_t n; LIST(NAMED_MEMBER) };

     size_t count = 0; LIST(NAMED_LENGTH)                    adds the lengths
     handle *s; real *at; LIST(NAMED_PLACE)                  places the arrays from `at` on
     const char *name; size_t *length; LIST(NAMED_FIND)      returns the array `name`, if it exists

   Lengths are expressions of variables in scope. */
#ifndef CARDSFLOW_NAMED_ARRAYS_H
#define CARDSFLOW_NAMED_ARRAYS_H

#include <stddef.h>

#define NAMED_MEMBER(name, length) real *name;
#define NAMED_LENGTH(name, length) count += length;
#define NAMED_PLACE(name, length) s->name = at, at += length;
#define NAMED_FIND(name_, length_) \
    if (!strcmp(name, #name_)) return *length = length_, s->name_;

/* Return a size in bytes, increased to a multiple of 8: arrays begin there, also if pointers have 4 bytes. */
static inline size_t padded(size_t size)
{
    return (size + 7u) & ~(size_t)7u;
}

#endif
