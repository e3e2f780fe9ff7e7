/* A tick of the monitor: residuals, statistics, suspicions, isolation. */
#include "state.h"

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

/* A fault of one length or encoder changes the residuals of the others: only the largest one is suspect, and the
   windows of the others begin again. Tensions are independent of each other. */
static void suspect_geometric(faults *s)
{
    size_t largest = s->c;
    for (size_t i = 0; i < s->c; i++)
        if ((i < s->m || i >= 2 * s->m) && is_candidate(s, i) && s->level[i] >= 1)
            if (largest == s->c || s->level[i] > s->level[largest]) largest = i;
    if (largest == s->c) return;
    suspect(s, largest);
    for (size_t i = 0; i < s->c; i++)
        if (i != largest && (i < s->m || i >= 2 * s->m)) s->since[i] = s->clock[0] + 1;
}

int faults_tick(faults *s, real h)
{
    s->now[0] += s->clock[0] > 0 ? h : 0;
    faults_set_limits(s, h);
    faults_fit(s);
    faults_compare_tensions(s, h);
    for (size_t i = 0; i < s->c; i++) faults_scan(s, i);
    suspect_geometric(s);
    for (size_t i = s->m; i < 2 * s->m; i++)
        if (is_candidate(s, i) && s->level[i] >= 1) suspect(s, i);
    faults_isolate(s);
    s->clock[0]++;
    int count = 0;
    for (size_t i = 0; i < s->p; i++) count += s->kind[i] != 0;
    return count;
}
