/* Parts of the core and the control laws that firmware can leave out. By default all parts are compiled.

   With -DCARDSFLOW_PARTS='"parts.h"', only parts that this file defines as 1 are compiled, and the linker
   option --gc-sections removes the rest: see docs/how_to/microcontrollers.md. A robot that needs another part
   is rejected when it is opened. USES_LAW_x is the muscle law x: see ../generated/law_table.h. */
#ifndef CARDSFLOW_OPTIONAL_PARTS_H
#define CARDSFLOW_OPTIONAL_PARTS_H

#if defined(CARDSFLOW_PARTS)
#include CARDSFLOW_PARTS
#define USES_OTHERS 0
#else
#define USES_OTHERS 1
#endif

#ifndef USES_WRAPS /* surfaces under muscles */
#define USES_WRAPS USES_OTHERS
#endif
#ifndef USES_ELLIPSOIDS
#define USES_ELLIPSOIDS USES_OTHERS
#endif
#ifndef USES_SEQUENCES /* swivelling pulleys, and several surfaces in one segment */
#define USES_SEQUENCES USES_OTHERS
#endif
#ifndef USES_ROUTES /* conditional and moving via points, branches, terms, rules of OpenSim and MuJoCo */
#define USES_ROUTES USES_OTHERS
#endif
#ifndef USES_CABLE_FRICTION
#define USES_CABLE_FRICTION USES_OTHERS
#endif
#ifndef USES_TASKS /* control in operational space */
#define USES_TASKS USES_OTHERS
#endif
#ifndef USES_NORMS /* of forces, other than 2 */
#define USES_NORMS USES_OTHERS
#endif

#endif
