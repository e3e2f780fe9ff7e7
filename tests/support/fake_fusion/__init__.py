"""A strict fake of the Fusion 360 API, for tests of the add-in without Fusion.

Use
---
`install()` starts a new Fusion without documents, puts `adsk`, `adsk.core`, `adsk.fusion` into
sys.modules, and gives a `Fake`, with which a test plays the user. In tests the fixture `fusion`
(tests/addin_sdfusion/conftest.py) does so::

    def test_reads_the_arm(fusion):
        from addin_sdfusion.fusion.design import read_design   # needs adsk: import it in the test
        design = designs.two_link_arm(seed=3, nesting=2)        # adsk.fusion.Design, now active
        snapshot = read_design(design, meshes=True)

At the top of a module, `with fake_fusion.modules(): from addin_sdfusion import fusion_design` works
too: the classes are always the same ones. Tests with hypothesis say `with fake_fusion.install():`
within, as a fixture is not made afresh for every example.

Designs
-------
`designs.<name>()` opens a document and gives its Design: see `designs`. To draw another one::

    build = Builder("arm", intent="hybrid")               # cm, kg, rad; poses are 4x4 arrays
    base = build.place("base", grounded=True)             # a path: (OccurrenceData, ...)
    arm = build.place("arm", translation((0, 0, 10)))     # fake_fusion.maths has the poses
    hand = build.place("hand", T, above=arm)              # within the arm; T relative to it
    twin = build.place(arm[-1].component, T2)             # the same component in another place
    build.box(arm, (1, 1, 10), density=1e-3)              # also cylinder, sphere, torus, explicit
    build.joint("elbow", "revolute", one=arm, two=base, origin=(0, 0, 10), axis=(0, 1, 0),
                values=(0.3,), limits=((-1.0, None),))    # as_built=, by_origins=, suppressed=, ...
    build.rigid_group("EXPORT_arm", [arm])
    build.point(hand, (0, 0, 1), "VP_motor0_EXPORT_arm_0")
    build.sketch((), points=[(1, 2, 0)])                  # () is the root
    design = build.done()

`entity.wrap(data, path)` gives the API's object for what the builder made.

The fake
--------
* Unknown members, written or read, raise AttributeError "Class has no member 'x'"; keyword
  arguments, wrong types and wrong numbers of arguments raise TypeError; objects cannot be hashed;
  every access makes a new wrapper: compare with ==. Retired members are absent.
* The model is edited in a command's execute and executePreview only. In a test: `with
  fake.building():` (the user did it before) or `with fake.transaction():` (one undo step).
* `fake.fingerprint()` is a text of all that is the user's: it must not change but by the user.
* `fake.options` (state.Options) holds what is unknown about Fusion: test that it does not matter.
* `fake.without("Design.designIntent")`: an older Fusion without that member.
* `fake.messages`, `fake.log`, `fake.world` (state.World): what the user was shown, what to answer.

Commands
--------
Once the add-in has added its commands, `fake.run_command(id)` presses the button and gives a
`driver.Driver`: `pick(id, entity)`, `set(id, value)`, `press(id)`, `row(id, i)`, `ok()`,
`cancel()`; `command[id]` is the API's input, `table(id)` what a table shows. What the user cannot
do raises `driver.Rejected`; what a handler raises reaches the test. Handlers that nobody keeps are
silent. `fake.world.folder_answers`, `file_answers`, `message_answers` answer dialogs, else they are
cancelled (message boxes: OK or Yes); `cancel_progress_after` cancels progress dialogs.

Seen in running Fusion: the default, held by test_live_facts.py
---------------------------------------------------------------
* allOccurrences fails with one unresolved reference; that occurrence has path and pose, and nothing
  else [inferred].
* AsBuiltJoint.transform is in the component that holds the joint, whatever the proxy. Of joints and
  joint origins that is not known: Options.joint_transforms.
* Geometry of joints and joint origins has its origin in the root, its axes in the component that it
  belongs to; stored in a joint it answers for the first place of the joint's component.
* Motion vectors are in the root frame. Angles of dragged joints are given on a grid of 0.1 degrees.
* As-built joints and rigid groups have health in the timeline only. Stale groups raise on name and
  token and hold nothing.
* A Point3D is rejected in parametric designs but while a base feature is edited; in that edit the
  design passes for direct, the timeline is hidden, and points cannot be named.
* Adding a point moves back what was moved and not captured.
* isGrounded and isGroundToParent are two flags; the first component of the root is grounded to its
  parent without telling (Builder(ground_first=False): that preference is off).
* In assembly designs every component is of another document.
* Collections are never None. A table's row is not deleted while one of its inputs tells of a
  change.

Meaning of what the reference leaves open, [inferred] unless marked
------------------------------------------------------------------
* Matrices act on column vectors; `a.transformBy(b)` is a = b·a; Vector3D is turned, not moved.
* Occurrence.transform2 "in its assembly context" [reference]: an occurrence in the root's context
  gives its pose in the root; a native one (Component.occurrences) its pose in its component.
* Joints: T_one = T_two · motion(values), the freedoms in the order of build.FREEDOMS from `two` to
  `one`. Directions are those on `two` (Options.ball_vectors for the ball joint). The
  geometry of an as-built joint belongs to `two`.
* A joint in a sub-component read natively has null geometry, or not (Options). Null geometry and
  motion of an inferred joint, null geometry of a rigid as-built joint [reference]; its transform is
  null too.
* The user's mass of a component scales its inertia; components above it count with it.
* An attribute belongs to the native entity, whatever proxy it was written through.
* findAttributes does not find the design's own attributes [reference].
* A construction point in a component other than the root, on an entity of another context, needs
  the creation occurrence [reference], else "Provided input paths are not valid.".
* Names of points, joints, groups, bodies are unique in their component, of components in the
  design: " (1)" is appended.
* An offset and angle of a joint are between two's frame and the motion; a flip turns one's frame
  over. A face's attribute or a light bulb is the native entity's.
* A command: commandCreated, then after each of the user's steps inputChanged,
  validateInputs, executePreview [manual]; what the add-in itself sets fires nothing. A button's
  value toggles. A click on a table's row fires nothing.
* Icons of 16x16 and 32x32 must be in a definition's resource folder, as PNG or SVG.
* Sketches cannot be made; joints cannot be driven: the add-in has no business there.
* Below VeryHigh accuracy mass is 1 %, 0.1 %, 0.01 % off.
"""

from __future__ import annotations

from . import designs
from .build import Builder
from .control import Fake
from .install import install, modules

__all__ = ["Builder", "Fake", "designs", "install", "modules"]
