/* Selection of the law in joint space. */
#include "law_choice.h"

#include "joint/joint_laws.h"

#include <string.h>

typedef struct {
    const char *name;
    void (*torque)(const computed_torque *s, real *tau);
    int needs_gravity;
} joint_law;

#define JOINT_LAW_ENTRY(name, needs_gravity) {#name, name##_torque, needs_gravity},
static const joint_law LAWS[] = {JOINT_LAWS(JOINT_LAW_ENTRY)};
#undef JOINT_LAW_ENTRY

enum { COUNT = sizeof LAWS / sizeof *LAWS };

int computed_torque_law(const char *name)
{
    for (int i = 0; i < COUNT; i++)
        if (!strcmp(LAWS[i].name, name)) return i;
    return COMPUTED_TORQUE_GIVEN;
}

static const joint_law *chosen_law(const computed_torque *s)
{
    return s->law[0] >= 0 && s->law[0] < COUNT ? &LAWS[(size_t)s->law[0]] : NULL;
}

void joint_law_torque(computed_torque *s)
{
    const joint_law *law = chosen_law(s);
    if (law) law->torque(s, s->tau);
}

int computed_torque_needs_gravity(const computed_torque *s)
{
    const joint_law *law = chosen_law(s);
    return law && law->needs_gravity;
}
