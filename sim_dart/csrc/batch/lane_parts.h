/* Parts of the core that are compiled for lanes, see ../optional_parts.h. */
#define USES_TASKS 1
#define USES_LAW_ideal 1
#define USES_LAW_elastic_cable 1
#define USES_LAW_path_spring 1
#define USES_LAW_passive_spring 1
#define USES_LAW_tendon_spring 1
