/* FMI 3.0: getting and setting variables of each type. */
#include "fmi3_types.h"

#include "../instance/variables.h"
#include "fmi3_component.h"

/* Return whether the arrays are valid; otherwise the instance fails. */
static int has_arrays(fmi3Instance instance, const void *references, size_t count,
                      const void *values, size_t value_count)
{
    if (!instance)
        return 0;
    if ((references || count == 0) && (values || value_count == 0))
        return 1;
    instance_fail(fmi3_instance(instance), "null pointer in access to a variable");
    return 0;
}

static fmi3Status no_variables_of_type(fmi3Instance instance, size_t count)
{
    if (!instance)
        return fmi3Error;
    if (count == 0)
        return fmi3OK;
    return (fmi3Status)instance_fail(fmi3_instance(instance),
                                     "this FMU has Float64 and Boolean variables only");
}

#define PRESENT(type, port_type, representation)                                                   \
    FMI3_Export fmi3Status fmi3Get##type(                                                          \
        fmi3Instance instance, const fmi3ValueReference valueReferences[],                         \
        size_t nValueReferences, fmi3##type values[], size_t nValues)                              \
    {                                                                                              \
        static const struct access access = {"get" #type, port_type, representation};             \
        const struct variables variables = {valueReferences, nValueReferences, nValues};           \
        if (!has_arrays(instance, valueReferences, nValueReferences, values, nValues))             \
            return fmi3Error;                                                                      \
        return (fmi3Status)get_variables(fmi3_instance(instance), &access, variables, values);     \
    }                                                                                              \
    FMI3_Export fmi3Status fmi3Set##type(                                                          \
        fmi3Instance instance, const fmi3ValueReference valueReferences[],                         \
        size_t nValueReferences, const fmi3##type values[], size_t nValues)                        \
    {                                                                                              \
        static const struct access access = {"set" #type, port_type, representation};             \
        const struct variables variables = {valueReferences, nValueReferences, nValues};           \
        if (!has_arrays(instance, valueReferences, nValueReferences, values, nValues))             \
            return fmi3Error;                                                                      \
        return (fmi3Status)set_variables(fmi3_instance(instance), &access, variables, values);     \
    }

PRESENT(Float64, PORT_REAL, AS_DOUBLE)
PRESENT(Boolean, PORT_BOOLEAN, AS_BOOL)

#define ABSENT(type)                                                                               \
    FMI3_Export fmi3Status fmi3Get##type(                                                          \
        fmi3Instance instance, const fmi3ValueReference valueReferences[],                         \
        size_t nValueReferences, fmi3##type values[], size_t nValues)                              \
    {                                                                                              \
        (void)valueReferences, (void)values, (void)nValues;                                        \
        return no_variables_of_type(instance, nValueReferences);                                   \
    }                                                                                              \
    FMI3_Export fmi3Status fmi3Set##type(                                                          \
        fmi3Instance instance, const fmi3ValueReference valueReferences[],                         \
        size_t nValueReferences, const fmi3##type values[], size_t nValues)                        \
    {                                                                                              \
        (void)valueReferences, (void)values, (void)nValues;                                        \
        return no_variables_of_type(instance, nValueReferences);                                   \
    }

ABSENT(Float32)
ABSENT(Int8)
ABSENT(UInt8)
ABSENT(Int16)
ABSENT(UInt16)
ABSENT(Int32)
ABSENT(UInt32)
ABSENT(Int64)
ABSENT(UInt64)
ABSENT(String)

FMI3_Export fmi3Status fmi3GetBinary(fmi3Instance instance,
                                     const fmi3ValueReference valueReferences[],
                                     size_t nValueReferences, size_t valueSizes[],
                                     fmi3Binary values[], size_t nValues)
{
    (void)valueReferences, (void)valueSizes, (void)values, (void)nValues;
    return no_variables_of_type(instance, nValueReferences);
}

FMI3_Export fmi3Status fmi3SetBinary(fmi3Instance instance,
                                     const fmi3ValueReference valueReferences[],
                                     size_t nValueReferences, const size_t valueSizes[],
                                     const fmi3Binary values[], size_t nValues)
{
    (void)valueReferences, (void)valueSizes, (void)values, (void)nValues;
    return no_variables_of_type(instance, nValueReferences);
}

FMI3_Export fmi3Status fmi3GetClock(fmi3Instance instance,
                                    const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences, fmi3Clock values[])
{
    (void)valueReferences, (void)values;
    return no_variables_of_type(instance, nValueReferences);
}

FMI3_Export fmi3Status fmi3SetClock(fmi3Instance instance,
                                    const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences, const fmi3Clock values[])
{
    (void)valueReferences, (void)values;
    return no_variables_of_type(instance, nValueReferences);
}
