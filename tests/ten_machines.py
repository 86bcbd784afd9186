"""Prints how `machine check` judges ten machines: other gears, screws and sizes, and two cranes, as the table of docs/machine/machines.md.

    python tests/ten_machines.py [FILE|NAME ...]        (default: the ten)

Tip errors are root mean squares over the triangular path, scaled with the machine, under the law that ships: ideal world with the payload of
the file, real world with full and with empty hook. FMU_DIR names the folder of the packed FMUs.
"""

import json
import re
import sys
import tempfile
from pathlib import Path

from native import call

#: Gear ratio, lead of the screw, mm, and time of an edge, s: that of the reference machine, or as much longer as the motors need.
GEARS = [(6, 8, 3), (8, 12, 3), (10, 10, 3), (10, 8, 6), (12, 12, 6), (14, 12, 6)]
#: Sizes of the booms; the last one with booms and payload of half the weight: a timber crane of 7 m.
BOOMS = {0.7: 1, 1.4: 1, 1.55: 0.5}
#: A loader crane with other gears and payload.
LOADER = {"extends": "hiab_xs031", "emla": {"N_gear": 8}, "bodies": {"PL": {"mass": 400}}}


def geared(gear, lead_mm, edge_time):
    """The reference machine with other gears and screws."""
    return {"extends": "reference", "emla": {"N_gear": gear, "rho": lead_mm / 1000}, "trajectories": {"triangular": {"edge_time": edge_time}}}


def ten(folder):
    """Names and files of the machines, written into a folder."""
    files = {}
    for gear, lead, time in GEARS:
        file = folder / f"gear_{gear}_{lead}.json"
        file.write_text(json.dumps(geared(gear, lead, time)))
        files[f"gear {gear}, lead {lead} mm, edge in {time} s"] = file
    for size, weight in BOOMS.items():
        file = folder / f"booms_{size}.json"
        done = call("hdrm-fmu", "machine", "scale", "--booms", size, "--output", file)
        assert done.returncode == 0, done.stderr
        machine = json.loads(file.read_text())
        for body in machine["bodies"].values():
            body["mass"] *= weight
            body["inertia_com"] = {name: weight * value for name, value in body["inertia_com"].items()}
        file.write_text(json.dumps(machine))
        files[f"booms × {size}" + (f", {weight} of the weight" if weight < 1 else "")] = file
    file = folder / "loader.json"
    file.write_text(json.dumps(LOADER))
    files["`hiab_xs031`, gear 8, payload 400 kg"] = file
    return files


def judged(machine):
    """The tip errors of the trials by name, mm, and what is wrong."""
    done = call("hdrm-fmu", "machine", "check", machine)
    errors = dict(re.findall(r"note: (.*): tip error RMSE ([\d.]+) mm", done.stdout))
    wrong = [line for line in done.stdout.splitlines() if not line.startswith("note: ")] if done.returncode else []
    return errors, wrong or done.stderr.splitlines()


def main(names):
    """Print a row a machine."""
    trials = ("ideal world, hook full", "real world, hook full", "real world, hook empty")
    print("| machine |", *(f"{trial}, mm |" for trial in trials), "verdict |\n|---|--:|--:|--:|---|")
    with tempfile.TemporaryDirectory() as folder:
        for name, file in ({name: name for name in names} or ten(Path(folder))).items():
            errors, wrong = judged(file)
            cells = [f"{errors.get(trial, '—')}" for trial in trials]
            print("|", " | ".join([name, *cells, "refused: " + "; ".join({wrong[0]: 1, wrong[-1]: 1}) if wrong else "kept"]), "|", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
