"""Run a controller on plant.fmu, then on hardware.fmu, and draw both in one figure.

    python examples/hardware_in_the_loop/compare.py planar_2r -o compared
    python examples/hardware_in_the_loop/compare.py roboy_left_arm -o compared

The hardware is the device emulator, in a separate process in real time. With --hardware URI it is
the device at that address: another machine, the reference device, or a robot.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from cardsflow_fmu import Experiment, Result, run
from cardsflow_fmu.cosim.pacing import describe_timeliness

EXAMPLES = Path(__file__).resolve().parent.parent

SIMULATED, HARDWARE = "simulated", "with hardware in the loop"

RATES: dict[str, dict[str, float]] = {
    "planar_2r": {"controller.period": 0.001, "run.step": 0.001},
    "roboy_left_arm": {"controller.period": 0.002, "run.step": 0.002},
}
"""Steps of the examples, for 1 kHz and 500 Hz, in [s]."""


@contextlib.contextmanager
def emulator(experiment: Path, key_file: str | None = None) -> Iterator[str]:
    """Yield the address of a device emulator in a separate process."""
    command = [sys.executable, "-m", "cardsflow_fmu.cli", "device", str(experiment), "--json"]
    command += ["--listen", "udp://127.0.0.1:0"]
    if key_file is not None:
        command += ["--key-file", key_file]
    device = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert device.stdout is not None
        yield json.loads(device.stdout.readline())["listening"]
    finally:
        device.terminate()
        device.wait(timeout=10)


DELAYED = {"controller.delay": 1, "controller.predict": False}
"""Delay of an exchange with hardware: one step, without prediction."""


def runs(example: str, output: Path, seconds: float | None, uri: str | None) -> dict[str, Result]:
    """Run on the plant, without and with a step of delay, and on the hardware."""
    changes: dict[str, object] = dict(RATES[example])
    if seconds is not None:
        changes["run.duration"] = seconds
    simulated = run(Experiment.load(EXAMPLES / example, changes), output / "plant")
    delayed = run(Experiment.load(EXAMPLES / example, changes | DELAYED), output / "delayed")
    with contextlib.ExitStack() as stack:
        link = uri or stack.enter_context(emulator(EXAMPLES / example))
        driven = Experiment.load(
            EXAMPLES / example, changes | {"hardware.link": link, "hardware.use": True}
        )
        real = run(driven, output / "hardware")
    return {SIMULATED: simulated, "simulated, one step of delay": delayed, HARDWARE: real}


def tracking_error(result: Result) -> np.ndarray:
    """Return the 2-norm of the tracking error of every row."""
    signals = list(result.summary["tracking"]["per_signal"])
    errors = [result[name] - result[name.replace(".", "_d.", 1)] for name in signals]
    return np.linalg.norm(errors, axis=0)


def draw(results: dict[str, Result], file: Path) -> None:
    """Draw joint positions, tracking errors and forces."""
    simulated, real = results[SIMULATED], results[HARDWARE]
    figure, (positions, errors, forces) = plt.subplots(3, 1, sharex=True, figsize=(8, 8))
    for axes, prefix in ((positions, "q."), (forces, "f.")):
        for name in (n for n in simulated.names if n.startswith(prefix)):
            axes.plot(simulated["time"], simulated[name], linewidth=2.5, alpha=0.5)
            axes.plot(real["time"], real[name], "k--", linewidth=0.6)
    for label, result in results.items():
        errors.semilogy(result["time"], np.maximum(tracking_error(result), 1e-9), label=label)
    positions.set_title("simulated (coloured), with hardware in the loop (dashed)")
    positions.set_ylabel("joint positions in rad")
    errors.set_ylabel(f"tracking error in {real.summary['tracking']['unit']}")
    errors.legend(ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
    forces.set_ylabel("forces in N")
    forces.set_xlabel("time in s")
    figure.savefig(file, dpi=100, bbox_inches="tight")
    plt.close(figure)


def digest(folder: Path) -> str:
    """Return the hash of the controller of a run."""
    return hashlib.sha256((folder / "controller.fmu").read_bytes()).hexdigest()


def main() -> int:
    """Run with the arguments of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("example", choices=RATES)
    parser.add_argument("-o", "--output", type=Path, default=Path("compared"))
    parser.add_argument(
        "--duration", type=float, help="duration of the run, in s (default: of the example)"
    )
    parser.add_argument("--hardware", metavar="URI", help="a device that is already there")
    options = parser.parse_args()
    results = runs(options.example, options.output, options.duration, options.hardware)
    simulated, real = results[SIMULATED], results[HARDWARE]
    draw(results, options.output / "compared.png")
    for label, result in results.items():
        tracking = result.summary["tracking"]
        print(f"{label:30} tracking RMS {tracking['rms']:.3g} {tracking['unit']}")
    same = digest(options.output / "plant") == digest(options.output / "hardware")
    print(f"controller.fmu {'is the same file' if same else 'DIFFERS'}")
    trips = real.summary["hardware"]["round_trip"]
    late = real.summary["real_time"]
    print(f"round trip {1e6 * trips['median']:.0f} µs, p99 {1e6 * trips['p99']:.0f} µs")
    print(describe_timeliness(late))
    print(options.output / "compared.png")
    gap = max(
        float(np.abs(simulated[name] - real[name][: len(simulated.rows)]).max())
        for name in simulated.names
        if name.startswith("q.")
    )
    print(f"largest difference of a joint position: {gap:.2g}")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
