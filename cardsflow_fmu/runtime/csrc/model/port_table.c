#include "port_table.h"

#include "../platform/crc32.h"
#include "../platform/read_file.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { FORMAT_VERSION = 2, VALUE_SIZE = 8 };

static const char MAGIC[8] = {'C', 'A', 'R', 'D', 'S', 'F', 'M', 'U'};

/* Reads values from the front. If the bytes are exhausted, the reader is damaged and returns zeros. */
struct reader {
    const unsigned char *at;
    size_t left;
    int damaged;
};

static const unsigned char *take(struct reader *reader, size_t size)
{
    static const unsigned char zeros[8];
    if (reader->damaged || reader->left < size) {
        reader->damaged = 1;
        return zeros;
    }
    const unsigned char *bytes = reader->at;
    reader->at += size;
    reader->left -= size;
    return bytes;
}

static uint64_t take_unsigned(struct reader *reader, size_t size)
{
    const unsigned char *bytes = take(reader, size);
    uint64_t value = 0;
    for (size_t i = size; i-- > 0;)
        value = value << 8 | bytes[i];
    return value;
}

static uint32_t take_u32(struct reader *reader)
{
    return (uint32_t)take_unsigned(reader, 4);
}

static double take_f64(struct reader *reader)
{
    uint64_t bits = take_unsigned(reader, 8);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static const char *take_string(struct reader *reader)
{
    size_t length = (size_t)take_unsigned(reader, 2);
    if (reader->left < length + 1 || memchr(reader->at, '\0', length) || reader->at[length])
        reader->damaged = 1;
    return reader->damaged ? "" : (const char *)take(reader, length + 1);
}

static int take_enum(struct reader *reader, int count)
{
    int value = (int)take_unsigned(reader, 1);
    if (value >= count)
        reader->damaged = 1;
    return reader->damaged ? 0 : value;
}

static int is_consistent(const struct port *port)
{
    int is_constant = port->variability >= VARIABILITY_FIXED;
    if ((port->causality == CAUSALITY_PARAMETER) != is_constant)
        return 0;
    if (port->type == PORT_REAL)
        return isfinite(port->start);
    return port->variability != VARIABILITY_CONTINUOUS && (port->start == 0 || port->start == 1);
}

/* Read the ports of the next variable, which may have at most `max_values` values. Return its number of values. */
static size_t take_variable(struct reader *reader, struct port *ports, size_t max_values)
{
    struct port port;
    port.type = (enum port_type)take_enum(reader, PORT_TYPES);
    port.causality = (enum causality)take_enum(reader, CAUSALITIES);
    port.variability = (enum variability)take_enum(reader, VARIABILITIES);
    port.size = take_u32(reader);
    port.start = 0;
    port.name = "";
    if (reader->damaged || port.size == 0 || port.size > max_values) {
        reader->damaged = 1;
        return 0;
    }
    for (size_t i = 0; i < port.size; i++) {
        ports[i] = port;
        ports[i].start = take_f64(reader);
        if (i > 0)
            ports[i].size = 0;
        if (!is_consistent(&ports[i]))
            reader->damaged = 1;
    }
    port.name = take_string(reader);
    for (size_t i = 0; i < port.size; i++)
        ports[i].name = port.name;
    return port.size;
}

static void take_variables(struct reader *reader, struct port_table *table)
{
    size_t filled = 0;
    for (uint32_t left = take_u32(reader); left > 0 && !reader->damaged; left--)
        filled += take_variable(reader, table->ports + filled, table->count - filled);
    if (filled != table->count)
        reader->damaged = 1;
}

/* Read the table. Return 0 if all fields have the format and no bytes remain. */
static int take_table(struct reader *reader, struct port_table *table)
{
    table->guid = take_string(reader);
    table->model_name = take_string(reader);
    table->package_version = take_string(reader);
    table->step = take_f64(reader);
    table->count = take_u32(reader);
    if (reader->damaged || !(table->step > 0) || !isfinite(table->step) ||
        table->count > reader->left / VALUE_SIZE)
        return 0;
    table->ports = calloc(table->count + 1, sizeof *table->ports);
    if (!table->ports)
        return 0;
    take_variables(reader, table);
    return !reader->damaged && reader->left == 0;
}

static const char *take_header(struct reader *reader, size_t size)
{
    if (memcmp(take(reader, sizeof MAGIC), MAGIC, sizeof MAGIC) != 0)
        return "is not a table of variables";
    uint32_t version = take_u32(reader);
    uint32_t length = take_u32(reader);
    uint32_t crc = take_u32(reader);
    if (reader->damaged || length != size)
        return "is cut off or damaged";
    if (version != FORMAT_VERSION)
        return "has an unknown format";
    return crc == crc32_of(reader->at, reader->left) ? NULL : "is damaged";
}

/* Return the error, or NULL. */
static const char *parse(struct port_table *table, size_t size)
{
    struct reader reader = {table->file, size, 0};
    const char *wrong = take_header(&reader, size);
    if (!wrong && !take_table(&reader, table))
        wrong = "is damaged";
    return wrong;
}

int port_table_read(struct port_table *table, const char *folder, struct text *error)
{
    size_t size = 0;
    memset(table, 0, sizeof *table);
    table->file = read_file(folder, "ports.bin", &size);
    const char *wrong = table->file ? parse(table, size) : "cannot be read";
    if (wrong) {
        text_set(error, "%s/ports.bin %s: unpack or build the FMU again", folder, wrong);
        port_table_free(table);
    }
    return wrong != NULL;
}

int port_table_copy(struct port_table *table, const void *bytes, size_t size, struct text *error)
{
    memset(table, 0, sizeof *table);
    table->file = malloc(size + 1);
    if (table->file)
        memcpy(table->file, bytes, size);
    const char *wrong = table->file ? parse(table, size) : "cannot be stored: out of memory";
    if (wrong) {
        text_set(error, "the table of variables %s", wrong);
        port_table_free(table);
    }
    return wrong != NULL;
}

void port_table_free(struct port_table *table)
{
    free(table->ports);
    free(table->file);
    memset(table, 0, sizeof *table);
}
