"""Run an .ssp in FMPy: argv = file, step, steps, variables as component.variable."""

import json
import sys

from fmpy.ssp.simulation import simulate_ssp

path, step, steps, *names = sys.argv[1:]
size = float(step)
result = simulate_ssp(path, stop_time=(int(steps) - 0.5) * size, step_size=size)
print(json.dumps([[float(row[name]) for name in names] for row in result]))
