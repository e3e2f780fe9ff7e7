"""A strict fake of the Fusion 360 API, for tests of the add-in without Fusion.

Use
---
`install()` starts a new Fusion without documents, adds `adsk`, `adsk.core`, `adsk.fusion` to
sys.modules, and yields a `Fake` that controls it. Tests use the fixture `fusion`
(tests/addin_sdfusion/conftest.py)::

    def test_reads_the_arm(fusion):
        from addin_sdfusion.fusion.design import read_design    # requires adsk
        design = designs.two_link_arm(seed=3, nesting=2)        # adsk.fusion.Design, now active
        snapshot = read_design(design, meshes=True)

At the top of a module, use `with fake_fusion.modules(): from addin_sdfusion import ...`; the
classes are always the same. Tests with hypothesis use `with fake_fusion.install():` in their body,
because a fixture is not created again for every example.

Designs
-------
`designs.<name>()` opens a document and returns its Design; see `designs`. To draw another design::

    build = Builder("arm", intent="hybrid")               # cm, kg, rad; poses are 4x4 arrays
    base = build.place("base", grounded=True)             # a path: (OccurrenceData, ...)
    arm = build.place("arm", translation((0, 0, 10)))     # poses: see fake_fusion.maths
    hand = build.place("hand", T, above=arm)              # child of arm; T relative to arm
    copy = build.place(arm[-1].component, T2)             # another occurrence of the component
    build.box(arm, (1, 1, 10), density=1e-3)              # also cylinder, sphere, torus, explicit
    build.joint("elbow", "revolute", one=arm, two=base, origin=(0, 0, 10), axis=(0, 1, 0),
                values=(0.3,), limits=((-1.0, None),))    # as_built=, by_origins=, suppressed=, ...
    build.rigid_group("EXPORT_arm", [arm])
    build.point(hand, (0, 0, 1), "VP_motor0_EXPORT_arm_0")
    build.sketch((), points=[(1, 2, 0)])                  # () is the root
    design = build.done()

`entity.wrap(data, path)` returns the API object of data created by the builder.

The fake
--------
* Reading or writing an unknown member raises AttributeError "Class has no member 'x'". Keyword
  arguments, wrong types and wrong numbers of arguments raise TypeError. Objects are not hashable.
  Every access creates a new wrapper: compare with ==. Retired members are missing.
* The model can be edited only in execute and executePreview of a command. Tests use `with
  fake.building():` (edits of the user before the test) or `with fake.transaction():` (one undo
  step).
* `fake.fingerprint()` is a text of all data of the user, which only the user may change.
* `fake.options` (state.Options) contains unknown properties of Fusion; tests check that they do
  not matter.
* `fake.designer` edits the design like a user: rename, get_latest (version suffix), paste,
  paste_new, move, suppress, configure, switch_configuration, resolve, delete, group; each action
  is one undo step (`designer`).
* `fake.world.waiting` contains actions that `adsk.doEvents` processes: of the user, or of Fusion.
* `fake.without("Design.designIntent")` simulates an older Fusion without this member.
* `fake.messages`, `fake.log`, `fake.world` (state.World): texts shown to the user, and answers.

Commands
--------
After the add-in has added its commands, `fake.run_command(id)` presses the button and returns a
`driver.Driver`: `pick(id, entity)`, `set(id, value)`, `press(id)`, `row(id, i)`, `ok()`,
`cancel()`. `command[id]` is the API input, and `table(id)` the content of a table. Actions that the
user cannot do raise `driver.Rejected`: also a click on a hidden entity, or on one inside a body.
Exceptions of handlers reach the test. Handlers without a reference are not called.
`fake.world.folder_answers`, `file_answers` and `message_answers` answer dialogs, which are
otherwise cancelled (message boxes: OK or Yes). `cancel_progress_after` cancels progress dialogs.

Observed in real Fusion; default behaviour, checked by test_live_facts.py
-------------------------------------------------------------------------
* allOccurrences fails if one reference is unresolved; this occurrence has only path and pose
  [inferred].
* AsBuiltJoint.transform is in the frame of the component that contains the joint, for any proxy.
  For joints and joint origins this is unknown: Options.joint_transforms.
* Geometry of joints and joint origins has its origin in the root frame and its axes in the frame
  of its component. Stored in a joint, it refers to the first occurrence of the joint's component.
* Motion vectors are in the root frame. Angles of dragged joints are rounded to 0.1 degrees.
* Only the timeline objects of as-built joints and rigid groups have a health state. Obsolete groups
  raise on name and token and have no members.
* Parametric designs accept a Point3D only while a base feature is edited. During the edit the
  design is treated as a direct design, the timeline is hidden, and points cannot be named.
* Adding a point reverts positions that are not captured.
* isGrounded and isGroundToParent are separate flags. The first component of the root is
  automatically grounded to its parent (Builder(ground_first=False) disables this preference).
* In assembly designs every component belongs to another document.
* Collections are never None. A row of a table cannot be deleted during an event of its inputs.

Assumptions where the reference is ambiguous, [inferred] unless marked
----------------------------------------------------------------------
* Matrices act on column vectors; `a.transformBy(b)` is a = b·a; a Vector3D is rotated, not moved.
* Occurrence.transform2 "in its assembly context" [reference]: an occurrence in the context of the
  root returns its pose in the root frame; a native one (Component.occurrences) in its component.
* Joints: T_one = T_two · motion(values), with degrees of freedom in the order of build.FREEDOMS
  from `two` to `one`. Directions are fixed to `two` (Options.ball_vectors for the ball joint). The
  geometry of an as-built joint belongs to `two`.
* A native joint of a sub-component may have null geometry (Options). Geometry and motion of an
  inferred joint are null, as is the geometry of a rigid as-built joint [reference] and its
  transform.
* A component mass set by the user scales its inertia and is included in parent components.
* An attribute belongs to the native entity, for any proxy that it was written through.
* findAttributes does not find attributes of the design itself [reference].
* A construction point in a component other than the root, on an entity of another context, requires
  the creation occurrence [reference], else "Provided input paths are not valid.".
* Names of points, joints, groups and bodies are unique in their component, names of components in
  the design: " (1)" is appended.
* Offset and angle of a joint are between the frame on `two` and the motion; a flip reverses the
  frame on `one`. The attributes and the visibility of a face belong to the native entity.
* Events of a command: commandCreated, then after each action of the user inputChanged,
  validateInputs, executePreview [manual]. Changes by the add-in cause no events, unless
  Options.change_events. The value of a button toggles. A click on a row of a table causes no event.
* The resource folder of a definition must contain icons of 16x16 and 32x32 pixels, as PNG or SVG.
* The names of occurrences follow their component, and contain the version of an external reference.
* Paste New copies points with their attributes; the new component has another id. Suppressed
  occurrences are not listed, but findAttributes still finds the points of their components. A token
  finds an occurrence after a rename, and after a move if Options.tokens_survive.
* Vertices, edges and faces become invalid when the model is recomputed: after an undo, an undone
  preview, a new point, and the edit of a base feature, which also makes its points invalid. Tokens
  find them again (Options.recomputed). Objects of an undone creation are invalid.
* Each configuration of an external reference is a component with its own id.
* Sketches cannot be created and joints cannot be driven, since the add-in must not do this.
* Below VeryHigh accuracy, masses have errors of 1 %, 0.1 % and 0.01 %.
"""

from __future__ import annotations

from . import designs
from .build import Builder
from .control import Fake
from .install import install, modules

__all__ = ["Builder", "Fake", "designs", "install", "modules"]
