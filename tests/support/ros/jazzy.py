"""ROS 2 for tests: the sourced distribution, or otherwise wheels of Jazzy in a cache.

    python jazzy.py

installs the wheels. They are not part of the test environment, like a ROS distribution:
environment variables contain the paths.
"""

from __future__ import annotations

import fcntl
import functools
import os
import platform
import secrets
import shutil
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

PACKAGES = (
    "ros-jazzy-rclpy>=7.1,<8",
    "ros-jazzy-rmw-fastrtps-cpp>=8.4,<9",
    "ros-jazzy-rosgraph-msgs>=2.0,<3",
    "ros-jazzy-sensor-msgs>=5.3,<6",
    "ros-jazzy-std-msgs>=5.3,<6",
    "ros-jazzy-visualization-msgs>=5.3,<6",
)
_SITE = "lib/python3.11/site-packages"


class NoRosError(Exception):
    """ROS 2 is not available for tests; the message contains the reason."""


@functools.cache
def ros_paths() -> dict[str, str]:
    """Return the environment variables for ROS 2.

    Raises:
        NoRosError: ROS 2 is not installed, and the wheels cannot be installed.
    """
    if find_spec("rclpy") is not None:
        return {}
    prefix = _installed()
    libraries = [prefix / "lib", *sorted((prefix / _SITE).glob("ros_*.libs"))]
    return {
        "PYTHONPATH": str(prefix / _SITE),
        "LD_LIBRARY_PATH": os.pathsep.join(map(str, libraries)),
        "AMENT_PREFIX_PATH": str(prefix),
        "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
    }


def ros_environment() -> dict[str, str]:
    """Return the environment for programs in a separate ROS domain, over loopback only."""
    environment = dict(os.environ)
    for name, paths in ros_paths().items():
        joined = [paths, environment.get(name, "")] if name.endswith("PATH") else [paths]
        environment[name] = os.pathsep.join(filter(None, joined))
    return environment | {
        "ROS_DOMAIN_ID": str(1 + secrets.randbelow(100)),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }


def _installed() -> Path:
    """Return the folder of the wheels; install them if necessary."""
    here = (sys.version_info[:2], sys.platform, platform.machine())
    if here != ((3, 11), "linux", "x86_64"):
        raise NoRosError("wheels of ROS 2 Jazzy are for Python 3.11 on Linux, x86_64")
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "cardsflow-tests"
    cache.mkdir(parents=True, exist_ok=True)
    place = cache / "ros-jazzy"
    with (cache / "ros-jazzy.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not place.is_dir():
            with tempfile.TemporaryDirectory(dir=cache) as new:
                _install(Path(new) / "ros")
                (Path(new) / "ros").rename(place)
    return place


def _install(prefix: Path) -> None:
    uv = shutil.which("uv")
    if uv is None:
        raise NoRosError("wheels of ROS 2 Jazzy are installed by uv, which is not there")
    command = [uv, "pip", "install", "--quiet", "--python", sys.executable, "--prefix", str(prefix)]
    done = subprocess.run([*command, *PACKAGES], capture_output=True, text=True, check=False)
    if done.returncode:
        raise NoRosError(f"wheels of ROS 2 Jazzy cannot be installed: {done.stderr.strip()[-200:]}")
    for folder in (prefix / _SITE).glob("numpy*"):  # the version of the test environment is used
        shutil.rmtree(folder)


if __name__ == "__main__":
    print(ros_paths())
