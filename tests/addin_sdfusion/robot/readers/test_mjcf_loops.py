"""Body equalities in MJCF: the position errors of loop joints agree with MuJoCo."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.oracles.moving_links import Matrix, MovingLinks

from addin_sdfusion.robot import Pose
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.model.rotations import rotation

pytestmark = pytest.mark.interop

MODEL = """<mujoco model="loop"><worldbody>
<body name="a" pos="0 0 1" euler="0 10 0"><joint name="ja" axis="0 1 0" ref="20"/>
 <geom size="0.1"/><site name="sa" pos="0.3 0.01 0" euler="0 20 0"/>
 <body name="b" pos="0.3 0 0" euler="10 0 30"><joint name="jb" axis="0 1 0"/><geom size="0.1"/>
 </body></body>
<body name="c" pos="0.7 0 1" euler="0 0 14"><joint name="jc" axis="0 1 0"/>
 <joint name="jd" axis="1 1 0" pos="0.1 0 0"/><geom size="0.1"/><site name="sc" pos="0.1 0.2 0.3"/>
</body></worldbody><equality>{}</equality></mujoco>"""


@pytest.mark.parametrize(
    ("equality", "ends"),
    [
        ('<connect body1="b" body2="c" anchor="0.4 0.1 0"/>', ("b", "c")),
        ('<connect body1="b" anchor="0.4 0.1 0"/>', ("world", "b")),
        ('<connect site1="sa" site2="sc"/>', ("a", "c")),
        ('<weld body1="b" body2="c"/>', ("b", "c")),
        (
            '<weld body1="b" body2="c" anchor="0.1 0.2 0.3" relpose="1 2 3 0.5 -0.5 0.5 0.1"/>',
            ("b", "c"),
        ),
        ('<weld body1="a" anchor="0.1 0.2 0.3"/>', ("world", "a")),
        ('<weld site1="sa" site2="sc"/>', ("a", "c")),
    ],
)
def test_loop_errors_agree_with_mujoco(
    equality: str, ends: tuple[str, str], tmp_path: Path
) -> None:
    mujoco = pytest.importorskip("mujoco")
    file = tmp_path / "loop.xml"
    file.write_text(MODEL.format(equality))
    robot = read(file).require()
    (loop,) = robot.loops
    assert (loop.parent, loop.child) == ends
    model = mujoco.MjModel.from_xml_path(str(file))
    data, names = mujoco.MjData(model), ["ja", "jb", "jc", "jd"]
    rng = np.random.default_rng(0)
    for q in rng.uniform(-1.0, 1.0, (4, 4)):
        data.qpos[:] = q
        mujoco.mj_fwdPosition(model, data)
        poses = MovingLinks(robot, dict(zip(names, q, strict=True))).poses
        here = poses[loop.parent] @ _matrix(loop.T_parent_joint)
        there = poses[loop.child] @ _matrix(loop.T_child_joint)
        gap = math.dist(here[:3, 3], there[:3, 3])
        assert gap == pytest.approx(np.linalg.norm(data.efc_pos[:3]), abs=1e-14)
        if loop.type == "fixed":  # MuJoCo uses the imaginary part of a quaternion
            cosine = (np.trace(here[:3, :3].T @ there[:3, :3]) - 1.0) / 2.0
            size = float(np.linalg.norm(data.efc_pos[3:6]))
            assert math.sqrt((1.0 - cosine) / 2.0) == pytest.approx(size, abs=1e-7)


def _matrix(pose: Pose) -> Matrix:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation(pose.rpy), pose.position
    return T
