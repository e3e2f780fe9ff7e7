/* Environment variables. */
#ifndef ENVIRONMENT_H
#define ENVIRONMENT_H

/* Return the value in UTF-8, on the heap; NULL if the variable is not set or empty. */
char *environment_get(const char *name);

/* Return the value as a positive number; `otherwise` if it is not a positive number. */
double environment_get_positive(const char *name, double otherwise);

#endif
