from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[3]

SCRIPT = """
import sys
sys.path.insert(0, sys.argv[1])
from addin_sdfusion.robot import Inertia, Joint, Link, Robot, WORLD, check, write_sdf
robot = Robot("r", (Link("a", Inertia(1.0)),), (Joint("j", WORLD, "a"),))
write_sdf(robot, sys.argv[2])
print([finding.code for finding in check(robot)], "lxml" in sys.modules)
"""


def test_robot_description_and_writers_need_only_the_standard_library(tmp_path):
    """Fusion has only the standard library: no site-packages, no environment."""
    command = [sys.executable, "-I", "-S", "-c", SCRIPT, str(ROOT), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.stdout == "['no-muscles'] False\n"
    assert (tmp_path / "model.sdf").is_file()


def test_add_in_folder_can_have_any_name(tmp_path):
    """Fusion loads the folder from any location; imports inside it are relative."""
    (tmp_path / "elsewhere").symlink_to(ROOT / "addin_sdfusion")
    script = SCRIPT.replace("addin_sdfusion", "elsewhere")
    command = [sys.executable, "-I", "-S", "-c", script, str(tmp_path), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stderr == ""
