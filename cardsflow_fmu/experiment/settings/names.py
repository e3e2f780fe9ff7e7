"""Names of the parts of a robot that have settings by name."""

from __future__ import annotations

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.trajectory import Space
from cardsflow_fmu.cosim.signals.ports import task_names
from cardsflow_fmu.experiment.config.names import Names


def robot_names(robot: Robot, space: Space = "joint") -> dict[str, Names]:
    """Return the names of all parts, by kind."""
    coordinates = Names("coordinate", [c.name for c in robot.coordinates])
    groups = {f.name: [f"{f.name}.{axis}" for axis in f.axes] for f in robot.task_frames}
    tasks = Names("task coordinate", task_names(robot), groups)
    muscles = [muscle.name for muscle in robot.muscles]
    motors = [coordinate.name for coordinate in robot.motors]
    points = [frame.name for frame in robot.task_frames if not frame.is_orientation]
    return {
        "coordinate": coordinates,
        "task coordinate": tasks,
        "followed": coordinates if space == "joint" else tasks,
        "muscle": Names("muscle", muscles),
        "motor": Names("motor", motors),
        "actuator": Names("muscle or motor", [*muscles, *motors]),
        "link": Names("link", [link.name for link in robot.links]),
        "point": Names("task frame that is a point", points),
    }
