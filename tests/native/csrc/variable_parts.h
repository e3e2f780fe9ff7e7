/* Parts of csrc/optional_parts.h as variables, so that one library has each selection of parts. */
extern int used_parts[7];
#define USES_WRAPS used_parts[0]
#define USES_ELLIPSOIDS used_parts[1]
#define USES_SEQUENCES used_parts[2]
#define USES_ROUTES used_parts[3]
#define USES_CABLE_FRICTION used_parts[4]
#define USES_TASKS used_parts[5]
#define USES_NORMS used_parts[6]
