#include "batch.h"

#include <math.h>

static double feature_value(const batch_feature *feature, const real *state, const double *targets)
{
    double value = feature->column < 0 ? 0.0 : feature->scale * state[feature->column];
    if (feature->target >= 0) value += targets[feature->target];
    return value;
}

void core_batch_features(const void *memory, size_t stride, int32_t count, int32_t size, const batch_feature *features,
                         int32_t width, const double *targets, const int32_t *answers, float *values, double *norms)
{
    for (int32_t k = 0; k < count; k++, targets += width, values += size) {
        const real *state = (const real *)(const void *)((const char *)memory + (size_t)k * stride);
        double squares[BATCH_NORMS] = {0};
        for (int32_t j = 0; j < size; j++) {
            const double value = feature_value(features + j, state, targets);
            values[j] = answers[k] ? 0.0F : (float)value;
            if (features[j].norm >= 0) squares[features[j].norm] += value * value;
        }
        for (int32_t i = 0; i < BATCH_NORMS; i++) norms[(size_t)i * (size_t)count + (size_t)k] = sqrt(squares[i]);
    }
}
