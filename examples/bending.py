"""A manipulator that bends, as a plant that shares no line with the controller's model: Bending.fmu.

Virtual hinges with springs cut the column (torsion), the lift boom between actuator pin and E, and the tilt boom behind C. Joints have
dry friction. Masses, centres of mass, dimensions and the direction of gravity are drawn by a seed. Encoders and rods sit before the
flexures and cannot see them: `tip.position` is where the tip is, `tip.rigid_position` where the joints say that it is.

    python examples/bending.py        natural frequencies and sag in the start pose and at full reach
"""

import json
from copy import deepcopy
from math import hypot, radians
from pathlib import Path

from mujoco_hdrm import MujocoHdrm

# Both booms level, the wrist nearly straight: joint angles, rad.
FULL_REACH = [0.0, radians(20), radians(-20), 0.0, radians(-10), 0.0]

class Bending(MujocoHdrm):
    """FMU: the interface of Hdrm.fmu, and what its sensors do not see."""

    description = "Manipulator that bends, in MuJoCo, with the interface of Hdrm"
    OUTPUTS = MujocoHdrm.OUTPUTS + [
        ("tip.rigid_position", 3, "m", "tip T4 at the present joint angles if no member were bent"),
        ("tip.sag", None, "m", "distance of the tip from where the joints say that it is"),
        ("flexure", 3, "rad", "angles of the flexures: column, lift boom, tilt boom"),
    ]
    PARAMETERS = MujocoHdrm.PARAMETERS | {
        "stiffness.column": (1.2e7, "N.m/rad", "torsional stiffness of the column"),
        "stiffness.lift": (1.2e7, "N.m/rad", "bending stiffness of the lift boom, at its virtual hinge"),
        "stiffness.tilt": (5.5e6, "N.m/rad", "bending stiffness of the tilt boom, at its virtual hinge"),
        "damping_time": (8e-4, "s", "damper over spring of a flexure; a mode's damping ratio is half of it times its frequency in rad/s"),
        "friction": (1.0, "1", "factor on the dry friction of the joints"),
        "seed": (0, None, "draws the errors below; 0 draws none"),
        "error.mass": (0.4, "1", "bound on the relative error of each body's mass"),
        "error.com": (0.05, "m", "bound on the error of each coordinate of a body's centre of mass"),
        "error.dimension": (1e-3, "m", "bound on the error of each length"),
        "error.gravity": (radians(1), "rad", "bound on the angle of gravity about both horizontal axes"),
    }

    def plant(self):
        from bending_plant import BendingPlant

        return BendingPlant(self.machine(), self.settings)


def main():
    from bending_plant import BendingPlant, modes

    machine = json.loads((Path(__file__).resolve().parent.parent / "parameters/reference_machine.json").read_text())
    reach = deepcopy(machine)
    reach["start"]["zeta"] = FULL_REACH
    for pose, of in {"start pose": machine, "full reach": reach}.items():
        plant = BendingPlant(of, {name: start for name, (start, _, _) in Bending.PARAMETERS.items()})
        frequencies, ratios, _ = modes(plant)
        x, _, z = plant.outputs()["tip.position"]
        print(f"{pose}: tip {hypot(x, z):.2f} m from the column, sag {1e3 * plant.outputs()['tip.sag'][0]:.2f} mm")
        for frequency, ratio in zip(frequencies, ratios):
            print(f"    {frequency:6.2f} Hz, damping ratio {1e2 * ratio:.2f} %")


if __name__ == "__main__":
    main()
