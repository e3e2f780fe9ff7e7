"""Step the FMUs of an experiment with FMPy only; no import of CARDSFlow.

cardsflow build examples/planar_2r -o fmus
python cosimulate.py fmus results.csv plant        # the simulated robot
python cosimulate.py fmus hardware.csv hardware    # hardware.fmu instead
"""

import csv
import shutil
import sys
from contextlib import ExitStack
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave


class Participant:
    """FMU of FMI 2.0 for co-simulation, with real inputs and outputs by name."""

    def __init__(self, path, stack):
        """Unpack and initialise the FMU; the stack frees it at the end."""
        description = read_model_description(path)
        real = [v for v in description.modelVariables if v.type == "Real"]
        self.inputs = {v.name: v.valueReference for v in real if v.causality == "input"}
        self.outputs = {v.name: v.valueReference for v in real if v.causality == "output"}
        experiment = description.defaultExperiment
        self.stop, self.step_size = float(experiment.stopTime), float(experiment.stepSize)
        unpacked = extract(path)
        stack.callback(shutil.rmtree, unpacked, ignore_errors=True)
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=unpacked,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=Path(path).stem,
        )
        self.fmu.instantiate()
        stack.callback(self.fmu.freeInstance)
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def read(self):
        """Return the current outputs by name."""
        values = self.fmu.getReal(list(self.outputs.values()))
        return dict(zip(self.outputs, values, strict=True))

    def step(self, time, size, signals):
        """Compute a step; inputs without a signal of the same name keep their start values."""
        connected = {key: signals[name] for name, key in self.inputs.items() if name in signals}
        self.fmu.setReal(list(connected), list(connected.values()))
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=size)


def cosimulate(folder, robot="plant"):
    """Return all signals at every step: first the controller, then reference and robot compute."""
    with ExitStack() as stack:
        participants = [
            Participant(f"{folder}/{name}.fmu", stack)
            for name in ("reference", "controller", robot)
        ]
        reference, controller, plant = participants
        step, ticks = plant.step_size, round(controller.step_size / plant.step_size)
        rows, last = [], round(plant.stop / step)
        for k in range(last + 1):
            signals = plant.read() | reference.read()
            if k % ticks == 0 and k < last:
                controller.step(k * step, controller.step_size, signals)
            signals |= controller.read()
            rows.append({"time": k * step} | signals)
            if k < last:
                reference.step(k * step, step, signals)
                plant.step(k * step, step, signals)
        for participant in participants:
            participant.fmu.terminate()
        return rows


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    fmus, results, *robot = sys.argv[1:]
    rows = cosimulate(fmus, *robot)
    with Path(results).open("w", newline="") as file:
        table = csv.DictWriter(file, rows[0])
        table.writeheader()
        table.writerows(rows)
    print(f"{len(rows)} rows in {results}")
