"""Builds the example FMUs with pythonfmu, all or those of the scripts named, and the systems with the bending plant and other batteries:
`python examples/build.py DIRECTORY [SCRIPT ...]`."""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from mujoco_model import program
from pythonfmu import FmuBuilder

HERE = Path(__file__).resolve().parent
MACHINE = HERE.parent / "parameters/reference_machine.json"
MUJOCO = ("plant_fmu.py", "mujoco_model.py", "mujoco_plant.py")
# Each with the other scripts that it imports.
SCRIPTS = {
    "mujoco_hdrm.py": MUJOCO,
    "bending.py": (*MUJOCO, "mujoco_hdrm.py", "bending_plant.py"),
    "rod_controller.py": (),
    "one_mass.py": (),
    "pack.py": (),
}


def build(script, folder):
    """The FMU of a script, as pythonfmu builds it. One in MuJoCo notes where `hdrm-fmu` is, which writes its machine."""
    files = [MACHINE, *(HERE / other for other in SCRIPTS[script])]
    with TemporaryDirectory() as notes:
        if MUJOCO[1] in SCRIPTS[script]:
            files.append(Path(notes, "hdrm-fmu.txt"))
            files[-1].write_text(str(Path(program()).resolve()))
        return Path(FmuBuilder.build_FMU(HERE / script, dest=Path(folder), project_files=files))


STRUCTURE = HERE.parent / "system/SystemStructure.ssd"
REAL = HERE.parent / "system/Real.ssd"
SAMPLED = """          <ssd:ParameterBinding>
            <ssd:ParameterValues>
              <ssv:ParameterSet version="1.0" name="sampled">
                <ssv:Parameters>
                  <ssv:Parameter name="sample_time"><ssv:Real value="0.001" unit="s"/></ssv:Parameter>
                </ssv:Parameters>
                <ssv:Units>
                  <ssc:Unit name="s"><ssc:BaseUnit s="1"/></ssc:Unit>
                </ssv:Units>
              </ssv:ParameterSet>
            </ssd:ParameterValues>
          </ssd:ParameterBinding>
"""
#: Where the bindings of the controller end, the first component.
BINDINGS_END = "        </ssd:ParameterBindings>\n"


def bending_system(folder, source=STRUCTURE, name="Manipulator", made="Bending"):
    """Bending.ssd: the machine's system with the bending plant, for a communication step of 0.5 ms at which the controller still samples
    once in 1 ms. At 1 ms the exchange between an actuator and the light end of a bending boom rings by itself (bending.md)."""
    text = source.read_text()
    for old, new in {
        f'version="1.0" name="{name}"': f'version="1.0" name="{made}"',
        "resources/Hdrm.fmu": "resources/Bending.fmu",
        'stepSize="0.001"': 'stepSize="0.0005"',
    }.items():
        if text.count(old) != 1:
            raise ValueError(f"{source} must hold `{old}` once, not {text.count(old)} times")
        text = text.replace(old, new)
    path = Path(folder, f"{made}.ssd")
    path.write_text(text.replace(BINDINGS_END, SAMPLED + BINDINGS_END, 1))
    return path


#: What the wrist of the bending plant, which has ideal drives, does not know.
DRIVES_OF_WRIST = ('"wrist.enable[', '"wrist.brake[', '"hdrm.brake.closing_time"')


def without(text, *names):
    """The text without the lines that have one of the names."""
    return "".join(line for line in text.splitlines(keepends=True) if not any(name in line for name in names))


def without_wrist_drives(path):
    path.write_text(without(path.read_text(), *DRIVES_OF_WRIST))
    return path


def strict_system(folder):
    """StrictBending.ssd: the system of the machine as built with the bending plant, and the parameter sets that it binds beside it."""
    resources = Path(folder, "resources")
    resources.mkdir(exist_ok=True)
    for name in ("real.ssv", "sensors.ssv"):
        (resources / name).write_bytes((REAL.parent / "resources" / name).read_bytes())
        without_wrist_drives(resources / name)
    return without_wrist_drives(bending_system(folder, REAL, "Real", "StrictBending"))


ELECTRIC = HERE.parent / "system/Electric.ssd"
CELLS = """        <ssd:ParameterBindings>
          <ssd:ParameterBinding>
            <ssd:ParameterValues>
              <ssv:ParameterSet version="1.0" name="cells">
                <ssv:Parameters>
                  <ssv:Parameter name="cells"><ssv:Real value="160" unit="1"/></ssv:Parameter>
                </ssv:Parameters>
                <ssv:Units>
                  <ssc:Unit name="1"><ssc:BaseUnit/></ssc:Unit>
                </ssv:Units>
              </ssv:ParameterSet>
            </ssd:ParameterValues>
          </ssd:ParameterBinding>
        </ssd:ParameterBindings>
      </ssd:Component>"""


def electric_systems(folder):
    """Pack.ssd and Battery.ssd: Electric.ssd with `pack.py` and with the crate `battery/` in the place of DcLink. Neither knows precharge, so
    the drives are not told of it."""
    plain = without(ELECTRIC.read_text(), '"ready"', '"precharging"')
    # A connector without a unit where pythonfmu tells none would be refused as different from one with it.
    pack = plain.replace("resources/DcLink.fmu", "resources/Pack.fmu").replace('version="1.0" name="Electric"', 'version="1.0" name="Pack"')
    battery = without(plain, '"i_battery"')
    battery = battery.replace("resources/DcLink.fmu", "resources/Battery.fmu").replace('version="1.0" name="Electric"', 'version="1.0" name="Battery"')
    battery = battery.replace('startElement="dclink" startConnector="v_dc"', 'startElement="dclink" startConnector="v"')
    battery = battery.replace('<ssd:Connector name="v_dc" kind="output">', '<ssd:Connector name="v" kind="output">')
    before, component, after = battery.partition('<ssd:Component name="dclink"')
    head, end, tail = after.partition("      </ssd:Component>")
    battery = before + component + head + CELLS + tail
    made = []
    for name, text in {"Pack.ssd": pack, "Battery.ssd": battery}.items():
        made.append(Path(folder, name))
        made[-1].write_text(text)
    return made


if __name__ == "__main__":
    folder, *scripts = sys.argv[1:]
    for script in scripts or SCRIPTS:
        print(build(script, folder))
    print(bending_system(folder), strict_system(folder), *electric_systems(folder))
