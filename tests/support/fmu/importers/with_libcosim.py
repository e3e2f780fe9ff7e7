"""Run an .ssp in libcosim: argv = file, step, steps, variables as component.variable."""

import json
import sys

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver

log_output_level(CosimLogLevel.WARNING)
path, step, steps, *names = sys.argv[1:]
execution = CosimExecution.from_ssp_file(ssp_path=path, step_size=round(float(step) * 1e9))
observer = CosimObserver.create_last_value()
assert execution.add_observer(observer)
slaves = {info.name.decode(): info.index for info in execution.slave_infos()}
references = {
    f"{slave}.{variable.name.decode()}": (index, variable.reference)
    for slave, index in slaves.items()
    for variable in execution.slave_variables(index)
}
rows = []
for _ in range(int(steps)):
    assert execution.step()
    rows.append(
        [
            observer.last_real_values(slave_index=index, variable_references=[reference])[0]
            for index, reference in (references[name] for name in names)
        ]
    )
print(json.dumps(rows))
