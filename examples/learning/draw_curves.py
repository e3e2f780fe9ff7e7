"""Train the planar arm with five seeds by both scripts, and draw returns over processor time.

python draw_curves.py trained curves.svg
"""

from __future__ import annotations

import argparse
import csv
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt

FOLDER = Path(__file__).parent
SEEDS = range(30, 35)
LONGER = ["--goal", "1.1", "--minutes", "0.2"]
"""Options with which gradients continue after their goal, to the returns of PPO."""
SCRIPTS = {"train_gradients.py": ("gradients", "C0", LONGER), "train_ppo.py": ("PPO", "C1", [])}


def rows_of(script: str, seed: int, folder: Path) -> list[dict[str, str]]:
    """Return the learning curve of a training, which runs first if its folder does not exist."""
    output = folder / f"{Path(script).stem}_{seed}"
    if not output.exists():
        options = ["--cpu", "--seed", str(seed), "-o", str(output), *SCRIPTS[script][2]]
        subprocess.run([sys.executable, str(FOLDER / script), *options], check=True)
    with (output / "curve.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def draw(folder: Path, file: Path) -> None:
    """Draw the curves of all trainings."""
    plt.rcParams |= {"svg.hashsalt": "curves", "font.size": 9}
    figure, axes = plt.subplots(figsize=(6.4, 3.0), layout="constrained")
    for seed in SEEDS:
        for script, (name, colour, _) in SCRIPTS.items():
            rows = rows_of(script, seed, folder)
            times, returns = (
                [float(r[k]) for r in rows] for k in ("cpu_seconds", "episode_return")
            )
            axes.plot(times, returns, colour, label=name if seed == SEEDS[0] else None, lw=1.2)
            axes.plot(times[-1], returns[-1], "o", color=colour, ms=4)
    axes.set(xlabel="processor time of the training in s", ylabel="return", xlim=(0, None))
    axes.grid(alpha=0.3)
    axes.legend(loc="lower right")
    figure.savefig(file, metadata={"Date": None})


def main() -> None:
    """Draw with the arguments of the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", type=Path, help="folder of the trainings")
    parser.add_argument("file", type=Path, help="image")
    given = parser.parse_args()
    draw(given.folder, given.file)


if __name__ == "__main__":
    main()
