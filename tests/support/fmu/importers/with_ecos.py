"""Run an .ssp in ecos: argv = file, step, steps, variables as component.variable."""

import json
import sys

from ecospy import EcosLib, EcosSimulation

EcosLib.set_log_level("warn")
path, step, steps, *names = sys.argv[1:]
rows = []
with EcosSimulation(step_size=float(step), ssp_path=path) as simulation:
    assert simulation.init()
    for _ in range(int(steps)):
        simulation.step()
        rows.append([simulation.get_real(name.replace(".", "::", 1)) for name in names])
    simulation.terminate()
print(json.dumps(rows))
