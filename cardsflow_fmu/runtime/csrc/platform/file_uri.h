/* Conversion of file URIs to paths. */
#ifndef FILE_URI_H
#define FILE_URI_H

/* Return the path of a URI such as file:///folder/a%20b, in UTF-8 and without a slash at its end, on the
 * heap. Return NULL if it is not a file URI, is damaged, or memory is insufficient. */
char *path_from_file_uri(const char *uri);

#endif
