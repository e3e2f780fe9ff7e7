/* Getting and setting the variables of an instance. */
#ifndef VARIABLES_H
#define VARIABLES_H

#include "instance.h"

#include <stddef.h>

enum status get_reals(struct instance *instance, const unsigned *references, size_t count,
                      double *values);
enum status set_reals(struct instance *instance, const unsigned *references, size_t count,
                      const double *values);
enum status get_booleans(struct instance *instance, const unsigned *references, size_t count,
                         int *values);
enum status set_booleans(struct instance *instance, const unsigned *references, size_t count,
                         const int *values);

#endif
