"""`hdrm-fmu machine pack`: FMUs and systems of a machine for tools that know no machine file.

They run as the shipped ones do with `--machine`, bit for bit, in our master and in FMPy, with and without the FMU's resources.
"""

import csv
import json
import os
import shutil
import zipfile
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest

import native
from test_wasm import WASM_DIR, get_reals, outcome, reals
from wasm_host import Component, FmuWasm, Plain

# Another payload and another gear than the shipped crane's, whose gains the rule gives and whose actuators no network was trained on.
OWN = {"extends": "hiab_xs031", "bodies": {"PL": {"mass": 240}}, "emla": {"N_gear": 9}}
NAME = "forester_2"
FILE_NAME = "forester-2.json"
READERS = ("Controller", "Emla", "Hdrm", "Rig")
SYSTEMS = ("Electric", "Manipulator", "Real", "RigTestbed", "Testbed")


@pytest.fixture(scope="module")
def packed(fmu_dir, file):
    out = file.with_name("packed")
    made = native.call("hdrm-fmu", "machine", "pack", file, "--out", out)
    assert made.returncode == 0, made.stderr
    return out


def described(fmu):
    with zipfile.ZipFile(fmu) as archive:
        return ElementTree.fromstring(archive.read("modelDescription.xml"))


def test_there_is_one_of_each_with_a_name_of_its_own(packed, fmu_dir):
    names = {*(f"{name}_{NAME}.fmu" for name in READERS), "DcLink.fmu", "Sensors.fmu"}
    assert {path.name for path in packed.iterdir()} == {*names, *(f"{name}_{NAME}.ssp" for name in SYSTEMS), "fmi3"}
    assert {path.name for path in (packed / "fmi3").iterdir()} == names
    for name in READERS:
        for folder, token in (("", "guid"), ("fmi3", "instantiationToken")):
            own, shipped = described(packed / folder / f"{name}_{NAME}.fmu"), described(fmu_dir / folder / f"{name}.fmu")
            assert own.get("modelName") == f"{name}_{NAME}" and own.get(token) != shipped.get(token)
    with zipfile.ZipFile(packed / f"Real_{NAME}.ssp") as archive:
        root = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
        assert root.get("name") == f"Real_{NAME}"
        sources = {element.get("source") for element in root.iter() if element.tag.endswith("}Component")}
        assert sources == {"resources/Sensors.fmu", *(f"resources/{name}_{NAME}.fmu" for name in ("Controller", "Hdrm", "Rig"))} <= set(archive.namelist())


def starts(fmu):
    return {variable.name: variable.start for variable in fmpy.read_model_description(fmu, validate=True).modelVariables}


def test_start_values_are_the_machines_and_the_rules(packed, file):
    gains = native.call("hdrm-fmu", "machine", "gains", file, "--world", "ideal").stdout
    ruled = {line.split()[0]: float(line.split()[1]) for line in gains.splitlines()}
    found = starts(packed / f"Controller_{NAME}.fmu")
    # The crane's file says `gamma` itself.
    assert len(ruled) == 6 and {name: float(found[name]) for name in ruled} == ruled
    assert float(starts(packed / f"Hdrm_{NAME}.fmu")["payload.mass"]) == 240
    assert float(starts(packed / f"Emla_{NAME}.fmu")["N_gear"]) == float(starts(packed / f"Rig_{NAME}.fmu")["N_gear"]) == 9


def last(table):
    with table.open() as lines:
        return list(csv.DictReader(lines))[-1]


@pytest.mark.parametrize("options", [[], ["--fmi", 3]], ids=["fmi2", "fmi3"])
@pytest.mark.parametrize("system", ["Manipulator", "Real", "Electric"])
def test_a_system_runs_as_with_the_machine_file(packed, file, fmu_dir, tmp_path, system, options):
    """Plain `cosim`, which knows no machine, on what was packed; `hdrm-fmu run --machine` on what ships."""
    both = ["--stop-time", 0.5, "--set", "controller.settle_time=0.1", "--set", "controller.trajectory=triangular", *options]
    wanted, found = tmp_path / "wanted.csv", tmp_path / "found.csv"
    signals = ["--signals", "hdrm.zeta*,emla_*.F,controller.tip_error_norm,controller.v_q*", "--csv"]
    ran = native.call("hdrm-fmu", "run", "--system", fmu_dir / f"{system}.ssp", "--machine", file, *both, *signals, wanted)
    assert wanted.is_file(), ran.stderr
    places = ["--fmu-dir", packed] if options else []
    ran = native.call("cosim", "run", "--system", packed / f"{system}_{NAME}.ssp", *places, *both, *signals, found)
    assert found.is_file(), ran.stderr
    assert last(found) == last(wanted) and found.read_bytes() == wanted.read_bytes()


def simulated(fmu, **starts):
    outputs = [*(f"f_hold[{k}]" for k in (1, 2, 3)), *(f"zeta_ddot[{k}]" for k in range(1, 7)), *(f"tip.position[{k}]" for k in (1, 2, 3)), "energy.potential"]
    return fmpy.simulate_fmu(str(fmu), stop_time=0.05, output_interval=1e-3, start_values=starts, output=outputs, fmi_type="CoSimulation")


def test_a_plant_is_the_machine_in_fmpy(packed, file, fmu_dir, tmp_path):
    """Bit for bit that of the machine file; also without the FMU's resources, where it must not be the reference machine."""
    wanted = simulated(fmu_dir / "Hdrm.fmu", machine_file=str(file))
    found = simulated(packed / f"Hdrm_{NAME}.fmu")
    reference = simulated(fmu_dir / "Hdrm.fmu")
    assert np.array_equal(found, wanted) and not np.array_equal(found, reference)
    bare = fmpy.extract(str(packed / f"Hdrm_{NAME}.fmu"), str(tmp_path / "bare"))
    shutil.rmtree(tmp_path / "bare/resources")
    assert np.array_equal(simulated(bare), wanted)


@pytest.fixture(scope="module")
def packed_wasm(fmu_dir, file, tmp_path_factory):
    """The same from FMUs with WebAssembly."""
    if not (WASM_DIR / "Hdrm.fmu").is_file():
        pytest.skip(f"no FMUs with WebAssembly in {WASM_DIR}; tests/README.md says how they are made")
    fmus, out = (tmp_path_factory.mktemp(name) for name in ("fmus", "wasm"))
    for archive in (*fmu_dir.glob("*.fmu"), *fmu_dir.glob("*.ssp")):
        (fmus / archive.name).symlink_to(archive)
    (fmus / "fmi3").symlink_to(WASM_DIR)
    made = native.call("hdrm-fmu", "machine", "pack", file, "--out", out, env=os.environ | {"FMU_DIR": str(fmus)})
    assert made.returncode == 0, made.stderr
    return out


@pytest.mark.parametrize("name, own", [("Hdrm", ("payload.mass", 240)), ("Rig", ("N_gear", 9)), ("Emla", ("N_gear", 9)), ("Controller", ("gamma", 150))])
def test_webassembly_is_the_machine_too(packed_wasm, tmp_path, name, own):
    """Start values and outputs of module and component are those of the library, bit for bit; neither has a file to read."""
    fmu = FmuWasm(packed_wasm / f"fmi3/{name}_{NAME}.fmu", tmp_path / name)

    def run(instance):
        instance.initialize()
        seen = []
        for k in range(50):
            seen += [get_reals(instance, reals(fmu, "output")), outcome(instance.step, 1e-3 * k, 1e-3)]
        return instance.get(own[0]), seen

    library = run(fmu.instance())
    assert np.ravel(library[0]).tolist() == [own[1]] and all(status is None for status in library[1][1::2])
    for host in (Plain, Component):
        assert run(host(fmu)) == library, host


def test_a_machine_file_still_counts(packed, fmu_dir):
    """Also the reference machine, by its name."""
    assert np.array_equal(simulated(packed / f"Hdrm_{NAME}.fmu", machine_file="reference"), simulated(fmu_dir / "Hdrm.fmu"))
    assert np.array_equal(simulated(packed / f"Hdrm_{NAME}.fmu", machine_file="sized"), simulated(fmu_dir / "Hdrm.fmu", machine_file="sized"))


@pytest.mark.parametrize(
    "own, words",
    [
        ({"extends": "reference", "emla": {"N_gear": -3}}, "`emla.N_gear` = -3"),
        ({"extends": "reference", "emla": {"N_gear": 80, "rho": 0.008}}, "no `controller.Lambda_position`"),
        ({"extends": "reference", "trajectories": {"cubic": {"vertices": [[3.1, 0.5, 0.1]] * 6000}}}, "at most 16384 fit into a library"),
    ],
)
def test_what_cannot_be_packed_leaves_the_folder(tmp_path, fmu_dir, own, words):
    file, out = tmp_path / "mine.json", tmp_path / "out"
    file.write_text(json.dumps(own))
    out.mkdir()
    (out / "Hdrm_mine.fmu").write_text("kept")
    made = native.call("hdrm-fmu", "machine", "pack", file, "--out", out)
    assert made.returncode == 1 and words in made.stderr, made.stderr
    assert [path.name for path in out.iterdir()] == ["Hdrm_mine.fmu"] and (out / "Hdrm_mine.fmu").read_text() == "kept"
