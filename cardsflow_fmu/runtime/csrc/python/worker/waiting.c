#include "waiting.h"

#include "../../platform/clock.h"

#ifdef _WIN32
#include <windows.h>

static void yield_processor(void)
{
    SwitchToThread();
}
#else
#include <sched.h>

static void yield_processor(void)
{
    sched_yield();
}
#endif

/* In s. A sleep and a wake-up take about 50 us. If the usual wait exceeds the first value, the process
 * sleeps early. If a poll takes as long as the last value, another process has used the processor and needs
 * it. */
static const double MAX_USUAL = 500e-6, MAX_SPIN = 1e-3, MIN_SPIN = 20e-6, CROWDED = 200e-6;

static void pause_processor(void)
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    __asm__ volatile("yield");
#endif
}

static int has_value(const uint32_t *word, uint32_t value)
{
    return __atomic_load_n(word, __ATOMIC_ACQUIRE) == value;
}

int wait_polling(const uint32_t *word, uint32_t value, const struct patience *patience)
{
    enum { LOOKS = 100 };
    double now = monotonic_seconds(), before;
    double end = now + (patience->usual < MAX_USUAL ? MAX_SPIN : MIN_SPIN);
    do {
        for (int i = 0; i < LOOKS; i++) {
            if (has_value(word, value))
                return 1;
            pause_processor();
        }
        yield_processor();
        before = now;
        now = monotonic_seconds();
    } while (now < end && now - before < CROWDED);
    return has_value(word, value);
}

void patience_learn(struct patience *patience, double waited)
{
    const double weight = 0.125;
    if (waited > 2 * MAX_USUAL)
        waited = 2 * MAX_USUAL;
    patience->usual += weight * (waited - patience->usual);
}
