"""The manipulator as a MuJoCo model behind pythonfmu: a third-party plant with the interface of Hdrm.fmu."""

from plant_fmu import PlantFmu


class MujocoHdrm(PlantFmu):
    """FMU: the interface of Hdrm.fmu."""

    description = "Manipulator in MuJoCo, with the interface of Hdrm"

    def plant(self):
        from mujoco_plant import Plant

        return Plant(self.machine(), self.settings["inertia_scale"])
