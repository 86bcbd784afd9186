"""Writes mechanism.xml, the manipulator with its closed loops for MuJoCo and Pinocchio, from the oracle's geometry.

    python tests/bench/make_mechanism.py

Needs tests/oracle/requirements.txt. To be run again when parameters/reference_machine.json changes.
"""

import json
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "oracle"))

from compare_mujoco import model  # noqa: E402
from mechanism import REFERENCE  # noqa: E402


def main():
    machine = json.loads(REFERENCE.read_text())
    plant = {"machine": machine, "inertia_scale": 1.0, "payload_mass": machine["bodies"]["PL"]["mass"]}
    (HERE / "mechanism.xml").write_text(model(plant) + "\n")


if __name__ == "__main__":
    main()
