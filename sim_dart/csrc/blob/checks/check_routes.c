#include "check_routes.h"

#include "../../numbers/real_functions.h"
#include "check_points.h"
#include "../message.h"

#include <math.h>

static int is_index(int32_t k, int32_t count)
{
    return k >= 0 && k < count;
}

static int check_conditions(const blob_view *b, char *message, size_t capacity)
{
    for (int k = 0; k < b->counts.conditions; k++) {
        const int32_t point = b->condition_point[k];
        if (!is_index(point, b->counts.points) || (k && point <= b->condition_point[k - 1]))
            return reject(message, capacity, "condition %d: via point %d is invalid or not in order", k, (int)point);
        if (!is_index(b->condition_coordinate[k], b->counts.variables))
            return reject(message, capacity, "condition %d: unknown coordinate", k);
        if (!(b->condition_low[k] <= b->condition_high[k]) || !(b->condition_smoothing[k] >= 0) ||
            !isfinite(b->condition_smoothing[k]))
            return reject(message, capacity, "condition %d: its limits are not an interval", k);
    }
    return 0;
}

static int check_moves(const blob_view *b, char *message, size_t capacity)
{
    if (!all_finite(b->piece, 5 * (size_t)b->counts.pieces))
        return reject(message, capacity, "a piece of a function is not finite");
    for (int k = 0; k < b->counts.moves; k++) {
        const int32_t point = b->move_point[k], first = b->move_first[k], pieces = b->move_pieces[k];
        if (!is_index(point, b->counts.points) || (k && point < b->move_point[k - 1]))
            return reject(message, capacity, "move %d: via point %d is invalid or not in order", k, (int)point);
        if (!is_index(b->move_coordinate[k], b->counts.variables) || !is_index(first, b->counts.pieces) || pieces < 1 ||
            pieces > b->counts.pieces - first)
            return reject(message, capacity, "move %d: unknown coordinate or function", k);
        if (!(b->move_low[k] <= b->move_high[k]) || !all_finite(b->move_axis + 3 * k, 3))
            return reject(message, capacity, "move %d: its limits or its axis are invalid", k);
    }
    return 0;
}

static int check_branches(const blob_view *b, char *message, size_t capacity)
{
    for (int k = 0; k < b->counts.branches; k++) {
        const int32_t point = b->branch_point[k];
        if (!is_index(point, b->counts.points) || (k && point <= b->branch_point[k - 1]))
            return reject(message, capacity, "branch %d: via point %d is invalid or not in order", k, (int)point);
        if (b->branch_divisor[k] == 0 || !all_finite(b->branch_divisor + k, 1))
            return reject(message, capacity, "branch %d: its divisor is 0 or not finite", k);
    }
    return 0;
}

static int check_terms(const blob_view *b, char *message, size_t capacity)
{
    for (int k = 0; k < b->counts.path_terms; k++) {
        if (!is_index(b->path_term_muscle[k], b->counts.muscles) || (k && b->path_term_muscle[k] < b->path_term_muscle[k - 1]))
            return reject(message, capacity, "term %d: muscle %d is invalid or not in order", k, (int)b->path_term_muscle[k]);
        if (!is_index(b->path_term_coordinate[k], b->counts.variables) || !all_finite(b->path_term_factor + k, 1))
            return reject(message, capacity, "term %d: unknown coordinate, or factor not finite", k);
    }
    return 0;
}

int check_routes(const blob_view *b, char *message, size_t capacity)
{
    return check_points("guide", b->guide_frame, b->guide_vector, b->counts.guides, b->counts.frames, message,
                        capacity) ||
           check_conditions(b, message, capacity) || check_moves(b, message, capacity) ||
           check_branches(b, message, capacity) || check_terms(b, message, capacity);
}
