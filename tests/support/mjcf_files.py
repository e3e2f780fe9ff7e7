"""Small MJCF files, each with a feature that MuJoCo's compiler resolves."""

from __future__ import annotations

HINGE = '<joint name="{0}" axis="{1}" range="-60 60"/>'
BALL = '<geom size=".1" pos=".1 .02 .03"/>'


def model(world: str, more: str = "") -> str:
    """Return a file with these bodies."""
    return f'<mujoco model="m">{more}<worldbody>{world}</worldbody></mujoco>'


def body(name: str, inner: str, place: str = 'pos="0 .1 .3"') -> str:
    """Return a body with further elements and a hinge of the same name, in degrees."""
    return f'<body name="{name}" {place}>{HINGE.format("q" + name, "1 2 3")}{inner}</body>'


ARM = body("a", BALL + '<site name="sa" pos=".05 0 .1"/>' + body(
    "b", BALL + '<site name="sb" pos="0 .06 .1"/>'))  # fmt: skip
GROUND = '<site name="s0" pos=".2 .3 .1"/>'


def tendon(path: str, more: str = "", actuator: str = "") -> str:
    """Return the arm with a tendon."""
    made = f'<tendon><spatial name="t" {more}>{path}</spatial></tendon>'
    return model(GROUND + ARM + WRAPS, f"{made}<actuator>{actuator}</actuator>")


def tendons(*paths: str) -> str:
    """Return the arm with a muscle at each tendon."""
    made = "".join(f'<spatial name="t{k}">{path}</spatial>' for k, path in enumerate(paths))
    pull = (f'<muscle tendon="t{k}" lengthrange=".1 .9" force="50"/>' for k in range(len(paths)))
    more = f"<tendon>{made}</tendon><actuator>{''.join(pull)}</actuator>"
    return model(GROUND + ARM + WRAPS, more)


WRAPS = (
    '<geom name="g" type="cylinder" size=".05 .1" pos=".1 .2 .2" euler="20 30 0"/>'
    '<geom name="h" size=".06" pos=".1 .15 .2"/><site name="side" pos=".1 .4 .2"/>'
)
SITES = '<site site="s0"/>{}<site site="sa"/><site site="sb"/>'
TYPE = 'type="mesh"'
TETRA = 'vertex="0 0 0 .2 0 0 0 .3 0 .05 .02 .2" face="0 2 1 0 1 3 1 2 3 2 0 3"'
OBJ = """v 0 0 0\nv .2 0 0\nv 0 .3 0\nv .05 .02 .2\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"""


def mesh(*pairs: tuple[str, str]) -> str:
    """Return bodies with the masses of meshes: attributes of each mesh and of its geometry."""
    bodies = [
        body(f"a{k}", f'<geom mesh="m{k}" {"" if "type" in geom else TYPE} {geom}/>')
        for k, (_, geom) in enumerate(pairs)
    ]
    assets = [f'<mesh name="m{k}" {asset}/>' for k, (asset, _) in enumerate(pairs)]
    moving = bodies[0].replace("</body>", body("b", BALL) + "</body>") + "".join(bodies[1:])
    return model(moving, f"<asset>{''.join(assets)}</asset>")


def equal(equalities: str) -> str:
    """Return a chain of four hinges and slides with equalities."""
    inner = BALL
    for name in "dcb":
        inner = BALL + body(name, inner)
    inner += '<joint name="s" type="slide" axis="0 1 1" ref=".2"/>'
    return model(body("a", inner), f"<equality>{equalities}</equality>")


FILES: dict[str, str] = {
    "radian": model(ARM, '<compiler angle="radian" eulerseq="zyx"/>').replace("60", "1"),
    "euler": model(body("a", BALL, 'euler="10 20 30"'), '<compiler eulerseq="XzY"/>'),
    "orientations": model(
        "".join(
            body(f"x{k}", BALL, f'pos="{k} 0 0" {way}')
            for k, way in enumerate(
                ['axisangle="1 1 0 40"', 'xyaxes="1 1 0 0 1 1"', 'zaxis="1 2 3"', 'quat="1 2 3 4"']
            )
        )
    ),
    "classes": model(
        body("a", '<geom size=".1"/><geom class="thin" pos=".2 0 0"/>').replace(
            "<body", '<body childclass="heavy"'
        ),
        '<default><geom density="500"/><default class="heavy">'
        '<geom density="900"/><joint armature=".02" damping=".3"/><default class="thin"><geom '
        'type="capsule" size=".02 .2"/></default></default></default>',
    ),
    "classes of two sections": model(
        ARM,
        '<default><geom density="500"/></default>'
        '<default><joint stiffness="3" springref="10" armature=".1"/></default>',
    ),
    "includes": model('<include file="arm.xml"/>', '<include file="options.xml"/>'),
    "replicate": model(
        '<replicate count="3" offset=".3 0 .1" euler="0 0 20">'
        + body("a", BALL).replace('"qa"', '"q"')
        + "</replicate>"
    ),
    "replicate in replicate": model(
        body(
            "a",
            BALL + '<replicate count="4" euler="0 0 30" sep="-">'
            '<geom size=".02 .1" type="capsule" pos=".2 0 0"/><replicate count="2" offset="0 0 .1">'
            '<geom size=".01" pos=".1 0 0"/></replicate></replicate>',
        )
    ),
    "frames": model(
        '<frame pos="1 2 3" euler="10 0 40"><frame zaxis="0 1 1">'
        + body("a", '<frame pos=".1 0 0" euler="0 30 0">' + BALL + body("b", BALL) + "</frame>")
        + "</frame></frame>"
    ),
    "meshes": mesh(
        ('file="parts/tetra.obj" scale="1 2 -1"', 'pos=".1 0 0" euler="10 20 0"'),
        ('file="parts/tetra.obj" inertia="exact"', 'mass="2"'),
        (f'{TETRA} inertia="convex"', 'density="300"'),
        (f'{TETRA} inertia="legacy"', ""),
        (f'{TETRA} inertia="shell"', 'density="3"'),
        (f'{TETRA} refpos=".1 0 .1" refquat="1 1 0 0"', ""),
        (TETRA, 'type="box"'),  # fitted to the mesh
    ),
    "mesh directory": mesh(('file="other/tetra.obj"', "")).replace(
        "<asset>", '<compiler meshdir="parts" strippath="true"/><asset>'
    ),
    "bounds": model(ARM, '<compiler boundmass="5" boundinertia=".5" balanceinertia="true"/>'),
    "total mass": model(ARM, '<compiler settotalmass="7"/>'),
    "groups": model(
        body("a", BALL + '<geom size=".3" group="3"/>'), '<compiler inertiagrouprange="0 2"/>'
    ),
    "inertia of geoms": model(
        body("a", BALL + '<inertial pos="1 0 0" mass="3" diaginertia="1 1 1"/>'),
        '<compiler inertiafromgeom="true"/>',
    ),
    "full inertia": model(
        body("a", '<inertial pos=".1 .2 0" mass="2" fullinertia=".3 .4 .5 .01 .02 -.03"/>')
    ),
    "shapes": model(
        body(
            "a",
            '<geom type="ellipsoid" size=".1 .2 .3"/><geom type="box" size=".1 .1 '
            '.2" pos="0 .2 0"/><geom type="capsule" fromto="0 0 0 .1 .2 .3" size=".05"/>'
            '<geom type="cylinder" fromto="0 0 0 .1 .2 -.3" size=".05" shellinertia="true"/>',
        )
    ),
    "joints of a body": model(
        '<body name="a" euler="0 40 0">'
        '<joint name="x" type="slide" axis="1 1 0" ref=".3"/>'
        '<joint name="y" pos=".1 0 0" ref="30"/>'
        f'<joint name="z" axis="0 1 0" pos="0 .2 .1" springdamper=".1 .4"/>{BALL}</body>'
    ),
    "a ball": model(
        body(
            "a",
            BALL + f'<body name="b" pos=".1 .1 0" euler="20 0 10"><joint name="n" '
            f'type="ball" pos="0 .1 0"/>{BALL}</body>',
        )
    ),
    "free": model(
        f'<body name="a" pos="1 0 2" euler="20 0 30"><freejoint name="f"/>{BALL}'
        + body("b", BALL)
        + "</body>"
    ),
    "couplings in a chain": equal(
        '<joint joint1="qd" joint2="qc" polycoef=".1 .5 .2 -.1 .05"/>'
        '<joint joint1="qc" joint2="qa" polycoef="0 2"/><joint joint1="s" joint2="qb"/>'
    ),
    "held": equal('<joint joint1="qb" polycoef=".3"/><joint joint1="s" active="false"/>'),
    "pulley, sphere, cylinder, cylinder with a side": tendons(
        SITES.format("") + '<pulley divisor="2"/><site site="sb"/><site site="s0"/>',
        SITES.format('<geom geom="h" sidesite="side"/>'),
        SITES.format('<geom geom="g"/>'),
        SITES.format('<geom geom="g" sidesite="side"/>'),
    ),
    "motor on a tendon": tendon(
        SITES.format(""),
        actuator='<motor tendon="t" gear="-2" ctrlrange="0 30" ctrllimited="true"/>',
    ),
    "spring": tendon(SITES.format(""), 'stiffness="100" damping="3"', '<motor joint="qa"/>'),
    "muscle by its scale": tendon(
        SITES.format(""),
        actuator='<muscle name="m" tendon="t" '
        'lengthrange=".1 .9" scale="300" gear="2"/><muscle joint="qb" lengthrange="-1 1"/>',
    ),
    "sum of joints": model(
        ARM,
        '<tendon><fixed name="t"><joint joint="qa" coef=".3"/><joint '
        'joint="qb" coef="-.2"/></fixed></tendon><actuator><position tendon="t"/></actuator>',
    ),
    "motor with armature": model(
        ARM, '<actuator><motor joint="qa" gear="3" armature=".2"/></actuator>'
    ),
    "servo of a class": model(
        ARM,
        '<default><default class="c"><position kp="7" kv=".1" '
        'ctrlrange="-1 1"/></default></default><actuator><position class="c" joint="qa" '
        'forcerange="-4 5"/></actuator>',
    ),
}
BESIDE = {
    "arm.xml": f"<mujocoinclude><include file='b.xml'/>{ARM}</mujocoinclude>",
    "b.xml": f"<mujocoinclude>{body('c', BALL)}</mujocoinclude>",
    "options.xml": '<mujocoinclude><option gravity="1 2 -3"/>'
    '<default><geom density="70"/></default>'
    "</mujocoinclude>",
    "parts/tetra.obj": OBJ,
}
"""Content of the files to which the models refer, by path."""
