/* The table of variables of an FMU, read from resources/ports.bin.
 *
 * The file is little-endian. A string consists of its length (u16), the bytes in UTF-8, and a zero byte:
 *
 *     8 bytes  magic "CARDSFMU"
 *     u32      version of this format, 2
 *     u32      length of the whole file
 *     u32      CRC-32 of all following bytes
 *     string   GUID
 *     string   model name
 *     string   version of the package that built the FMU
 *     f64      preferred communication step, in s
 *     u32      number of values
 *     u32      number of variables; then each variable. Its value reference is the index of its first value:
 *         u8       type: 0 real, 1 boolean
 *         u8       causality: 0 input, 1 output, 2 parameter
 *         u8       variability: 0 continuous, 1 discrete, 2 fixed, 3 tunable
 *         u32      number of its values: more than one for an array
 *         f64      start value, for each value
 *         string   name */
#ifndef PORT_TABLE_H
#define PORT_TABLE_H

#include "../platform/text.h"

#include <stddef.h>

enum port_type { PORT_REAL, PORT_BOOLEAN, PORT_TYPES };
enum causality { CAUSALITY_INPUT, CAUSALITY_OUTPUT, CAUSALITY_PARAMETER, CAUSALITIES };
enum variability {
    VARIABILITY_CONTINUOUS,
    VARIABILITY_DISCRETE,
    VARIABILITY_FIXED,
    VARIABILITY_TUNABLE,
    VARIABILITIES
};

/* Port of one value: a variable, or an element of an array. */
struct port {
    enum port_type type;
    enum causality causality;
    enum variability variability;
    size_t size; /* size of the variable that begins here; 0 for other elements of an array */
    double start;
    const char *name; /* name of the variable */
};

struct port_table {
    const char *guid;
    const char *model_name;
    const char *package_version;
    double step;  /* preferred, in s */
    size_t count; /* of values */
    struct port *ports;
    unsigned char *file; /* contains the strings */
};

/* Read the table of the FMU with its resources in `folder`. Return 0, or nonzero with a message. */
int port_table_read(struct port_table *table, const char *folder, struct text *error);

/* Read the table from a copy of the bytes of the file. */
int port_table_copy(struct port_table *table, const void *bytes, size_t size, struct text *error);

void port_table_free(struct port_table *table);

#endif
