/* Resource locations: file URIs to paths. */
#ifndef FILE_URI_H
#define FILE_URI_H

/* The path that a URI such as file:///folder/a%20b names, in UTF-8 and without a slash at its end,
 * on the heap. NULL when it is not a file URI, is damaged, or without memory. */
char *path_from_file_uri(const char *uri);

#endif
