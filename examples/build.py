"""Builds the example FMUs with pythonfmu: `python examples/build.py DIRECTORY`."""

import re
import sys
import zipfile
from pathlib import Path

from pythonfmu import FmuBuilder

HERE = Path(__file__).resolve().parent
MACHINE = HERE.parent / "parameters/reference_machine.json"
SCRIPTS = ("mujoco_hdrm.py", "rod_controller.py", "one_mass.py")


def build(script, folder):
    """The FMU of a script. pythonfmu does not say what outputs depend on, which means: on every input. These FMUs change
    their outputs in fmi2DoStep only, so that is what the model structure is made to say; else masters find algebraic loops."""
    made = Path(FmuBuilder.build_FMU(HERE / script, dest=Path(folder), project_files=[MACHINE]))
    with zipfile.ZipFile(made) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    description = files["modelDescription.xml"].decode()
    description = re.sub(r'(<Unknown index="\d+")\s*/>', r'\1 dependencies=""/>', description)
    files["modelDescription.xml"] = description.encode()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return made


if __name__ == "__main__":
    for script in SCRIPTS:
        print(build(script, sys.argv[1]))
