"""Run one FMU in FMPy and print final values: argv = file, step, end, variables."""

import json
import sys

import fmpy.validation
import numpy as np

path, step, end, *names = sys.argv[1:]
problems = fmpy.validation.validate_fmu(path)
assert not problems, problems
result = fmpy.simulate_fmu(
    path,
    stop_time=float(end),
    step_size=float(step),
    output_interval=float(step),
    fmi_type="CoSimulation",
    output=names,
)
print(json.dumps([np.ravel(result[name][-1]).tolist() for name in names]))
