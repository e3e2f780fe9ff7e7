/* Environment variables. */
#ifndef ENVIRONMENT_H
#define ENVIRONMENT_H

/* The value in UTF-8, on the heap; NULL when the variable is not set or is empty. */
char *environment_get(const char *name);

/* The value as a positive number; `otherwise` when it is none. */
double environment_get_positive(const char *name, double otherwise);

#endif
