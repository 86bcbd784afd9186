"""Tip errors on the bending plant, for inertias of the plant and for errors drawn by seed, over both trajectories.

    python examples/bending_table.py target/fmu [--seeds 5] [--modes adaptive modular pd] [--trajectories triangular cubic]

The folder holds the packed FMUs and those of `python examples/build.py`. Root mean square (largest) in mm of the motion:
known: the reference against the controller's own kinematics of the true joint angles; rigid: against the tip that the joints of the plant
as drawn say, if nothing bent; true: against the tip; true less mean; sag: the tip from where the joints say that it is.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

from fmpy_master import Master  # noqa: E402
from fmu import Fmu  # noqa: E402
from system import System  # noqa: E402

SETTLE = 4.0  # s
ENDS = {"triangular": 13.75, "cubic": 24.25}  # s
POINTS = ("controller.desired.position", "hdrm.tip.position", "hdrm.tip.rigid_position")
NAMES = ["controller.tip_error_norm", "hdrm.tip.sag", *(f"{point}[{i}]" for point in POINTS for i in (1, 2, 3))]


def cell(errors):
    """Root mean square and largest of rows of vectors or of lengths, mm."""
    size = np.linalg.norm(errors.reshape(len(errors), -1), axis=1)
    return f"{1e3 * np.sqrt(np.mean(size**2)):.3f} ({1e3 * size.max():.3f})"


def line(system, fmus, trajectory, mode, plant):
    settings = {"controller": {"trajectory": trajectory, "mode": mode}, "hdrm": plant}
    master = Master(system, fmus, settings, h=5e-4)
    times, rows = master.record(ENDS[trajectory], NAMES)
    master.free()
    known, sag, wanted, tip, rigid = np.split(rows[times >= SETTLE], [1, 2, 5, 8], axis=1)
    true = wanted - tip
    cells = [known, wanted - rigid, true, true - true.mean(axis=0), sag]
    (name, value), = plant.items()
    print("|", " | ".join([trajectory, mode, f"{name} {value}", *map(cell, cells)]), "|", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--modes", nargs="+", default=["adaptive"])
    parser.add_argument("--trajectories", nargs="+", default=list(ENDS), choices=list(ENDS))
    arguments = parser.parse_args()
    system = System.read(arguments.folder / "Bending.ssd")
    unpacked = Path(tempfile.mkdtemp())
    fmus = {name: Fmu(arguments.folder / name, unpacked / name) for name in set(system.components.values())}
    plants = [{"inertia_scale": scale} for scale in (1.4, 1.2, 1.0, 0.8, 0.6)]
    plants += [{"seed": seed} for seed in range(1, arguments.seeds + 1)]
    print("| trajectory | mode | plant | known | rigid | true | true less mean | sag |\n|---|---|---|--:|--:|--:|--:|--:|")
    for trajectory in arguments.trajectories:
        for mode in arguments.modes:
            for plant in plants:
                line(system, fmus, trajectory, mode, plant)


if __name__ == "__main__":
    main()
