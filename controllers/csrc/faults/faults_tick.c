/* A tick of the monitor: residuals, statistics, suspicions, isolation. */
#include "hypotheses.h"

static void suspect(faults *s, size_t channel)
{
    s->suspicion[channel] = s->clock[0];
    s->suspect[faults_part(s, channel)] = 1;
}

/* A channel can become suspect if none of its muscle's parts has a fault. */
static int is_candidate(const faults *s, size_t channel)
{
    if (!faults_is_used(s, channel)) return 0;
    if (channel >= 2 * s->m) return 1;
    const size_t muscle = channel % s->m;
    return s->kind[muscle] == 0;
}

/* Return a length that is exchanged with another one in this tick, apart from noise, or c. */
static size_t find_swap(const faults *s)
{
    const real now = s->clock[0];
    for (size_t i = 0; i < s->m; i++)
        for (size_t k = 0; k < i && s->level[i] >= 1 && is_candidate(s, i); k++) {
            if (!(s->level[k] >= 1 && is_candidate(s, k))) continue;
            const fault_fit a = faults_fit_swap(s, i, k, now), b = faults_fit_swap(s, k, i, now);
            real rest = -a.factor - b.factor;
            for (size_t j = i;; j = k) {
                const size_t at = faults_at(s, j, now);
                rest += s->weight[at] * s->residual[at] * s->residual[at] / 2;
                if (j == k) break;
            }
            if (rest < s->limit) return i;
        }
    return s->c;
}

/* A fault of one length or encoder changes the residuals of the others: only the largest one is suspect, and the
   windows of the others begin again. Tensions are independent of each other. */
static void suspect_geometric(faults *s)
{
    size_t largest = s->c;
    for (size_t i = 0; i < s->c; i++)
        if ((i < s->m || i >= 2 * s->m) && is_candidate(s, i) && s->level[i] >= 1)
            if (largest == s->c || s->level[i] > s->level[largest]) largest = i;
    if (largest == s->c) return;
    /* two exchanged lengths over the same joint differ more from its encoder than from the other sensors */
    const size_t swapped = largest >= 2 * s->m ? find_swap(s) : s->c;
    if (swapped < s->c) largest = swapped;
    suspect(s, largest);
    for (size_t i = 0; i < s->c; i++)
        if (i != largest && (i < s->m || i >= 2 * s->m)) s->since[i] = s->clock[0] + 1;
}

static int count_faults(const faults *s)
{
    int count = 0;
    for (size_t i = 0; i < s->p; i++) count += s->kind[i] != 0;
    return count;
}

int faults_move(faults *s, real h, int steps)
{
    s->clock[0]--; /* the tick of the measurements */
    if (faults_follow_motion(s, h, steps)) faults_isolate_motion(s, h);
    s->clock[0]++;
    return count_faults(s);
}

/* Add h without a loss of digits (Kahan 1965). */
static void advance_time(faults *s, real h)
{
    volatile const real part = h - s->now_rest[0], sum = s->now[0] + part, added = sum - s->now[0];
    s->now_rest[0] = added - part;
    s->now[0] = sum;
}

/* Ticks are exact in single precision, since they are counted from a multiple of TURN. */
static void turn_clock(faults *s)
{
    int is_busy = s->followed[0] >= 0;
    for (size_t i = 0; i < s->c; i++) is_busy |= s->suspicion[i] >= 0;
    if (is_busy || s->clock[0] < TURN + WINDOW) return;
    s->clock[0] -= TURN, s->motion_tick[0] -= TURN;
    if (s->motion_begin[0] >= 0) s->motion_begin[0] = larger(s->motion_begin[0] - TURN, 0);
    for (size_t i = 0; i < s->c; i++) s->since[i] = larger(s->since[i] - TURN, 0);
}

int faults_tick(faults *s, real h)
{
    if (s->clock[0] > 0) advance_time(s, h);
    if (h != s->step) faults_set_limits(s, s->step = h);
    faults_fit(s);
    faults_compare_tensions(s, h);
    faults_scan(s);
    suspect_geometric(s);
    for (size_t i = s->m; i < 2 * s->m; i++)
        if (is_candidate(s, i) && s->level[i] >= 1) suspect(s, i);
    faults_isolate(s);
    s->clock[0]++;
    turn_clock(s);
    return count_faults(s);
}
