"""Files in an FMU's `resources` that are compiled in as well: the one in the archive counts, whoever edited it."""

import json
import re
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest

from fmu import Fmu
from fmu3 import Fmu3

MACHINE = "resources/reference_machine.json"
NETWORK = "resources/surrogate.json"
INTERFACES = [(folder, kind) for folder in ("", "fmi3") for kind in ("CoSimulation", "ModelExchange")]


def edited(archive, out, files):
    """A copy of an archive with other contents of these files; None removes one."""
    with zipfile.ZipFile(archive) as old, zipfile.ZipFile(out, "w") as new:
        for entry in old.infolist():
            content = files.get(entry.filename, old.read(entry))
            if content is not None:
                new.writestr(entry, content)
    return out


def machine_with(archive, **numbers):
    """The archive's reference machine with other numbers in the fields of these names."""
    text = zipfile.ZipFile(archive).read(MACHINE).decode()
    for field, number in numbers.items():
        text, count = re.subn(rf'"{field}": [\d.]+', f'"{field}": {number}', text)
        assert count
    return text


def run(archive, kind, **start):
    values = {"v_q": 20.0, **start}
    outputs = ["i_d", "i_q", "w_m", "P_loss"]
    result = fmpy.simulate_fmu(str(archive), fmi_type=kind, stop_time=0.02, output_interval=1e-3, start_values=values, output=outputs)
    return np.array([list(row) for row in result])


@pytest.mark.parametrize("folder, kind", INTERFACES)
def test_an_edited_machine_gives_other_numbers(fmu_dir, tmp_path, folder, kind):
    """Oracle: the unedited FMU with the same number set as a parameter. What is set explicitly still counts before the file."""
    archive = fmu_dir / folder / "Emla.fmu"
    other = edited(archive, tmp_path / "Emla.fmu", {MACHINE: machine_with(archive, R_s=0.7)})
    found, wanted = run(other, kind), run(archive, kind, R_s=0.7)
    assert np.array_equal(found, wanted) and not np.allclose(wanted[-1], run(archive, kind)[-1])
    assert np.array_equal(run(other, kind, R_s=0.4), run(archive, kind, R_s=0.4))
    # The network, blended in.
    network = json.loads(zipfile.ZipFile(archive).read(NETWORK))
    text = json.dumps(network, indent=1)
    same = edited(archive, tmp_path / "Same.fmu", {NETWORK: text})
    assert np.array_equal(run(same, kind, alpha=1.0), run(archive, kind, alpha=1.0))


def test_every_fmu_takes_its_machine_from_the_archive(fmu_dir, tmp_path):
    energy = {}
    for name, field, number, variable, expected in [
        ("Rig", "R_s", 0.7, "R_s", 0.7),
        ("Controller", "gamma", 777.0, "gamma", 777.0),
        ("Hdrm", "gravity", 4.905, "energy.potential", None),
    ]:
        archive = fmu_dir / f"{name}.fmu"
        other = edited(archive, tmp_path / f"{name}.fmu", {MACHINE: machine_with(archive, **{field: number})})
        for file in (archive, other):
            fmu = Fmu(file, tmp_path / f"{name}-{file == other}")
            instance = fmu.instance(logging=True).start()
            energy[file == other] = instance.get(variable)
            said = [text for _, _, category, _, text in instance.messages if "differs from what is compiled in" in text]
            assert len(said) == (file == other)
            assert all("`reference_machine.json` in the resources folder" in text for text in said)
            assert instance.get("machine_file") == ("reference_machine.json" if file == other else "")
            before = instance.get(variable)
            instance.call("fmi2Reset")
            assert instance.start().get(variable) == before
            instance.free()
        assert energy[True] == (energy[False] / 2.0 if expected is None else expected)


def test_a_shipped_machine_by_name_is_the_one_in_the_archive(fmu_dir, tmp_path):
    archive = fmu_dir / "Emla.fmu"
    path = "resources/sized_machine.json"
    machine = json.loads(zipfile.ZipFile(archive).read(path))
    machine["emla"]["slew"]["R_s"] = 0.123
    other = edited(archive, tmp_path / "Emla.fmu", {path: json.dumps(machine)})
    instance = Fmu(other, tmp_path / "emla").instance()
    instance.set({"machine_file": "sized"})
    assert instance.start().get("R_s") == 0.123
    instance.free()


@pytest.mark.parametrize("folder", ["", "fmi3"])
def test_a_bad_file_in_the_archive_is_refused(fmu_dir, tmp_path, folder, monkeypatch):
    """No instance, and the file and the row are named; a file of this name in the working directory makes no difference."""
    archive = fmu_dir / folder / "Emla.fmu"
    monkeypatch.chdir(tmp_path)
    Path("reference_machine.json").write_text(machine_with(archive, R_s=0.9))
    for k, (files, words) in enumerate([
        ({MACHINE: machine_with(archive, R_s=0.0)}, ["`machine_file`", "reference_machine.json", "`emla.R_s` = 0 must be finite and > 0"]),
        ({MACHINE: "{"}, ["reference_machine.json", "line 1", "column"]),
        ({NETWORK: "[]"}, ["`surrogate_file`", "surrogate.json"]),
        ({MACHINE: b"\xff\xfe\xff"}, ["`machine_file`", "reference_machine.json"]),
    ]):  # fmt: skip
        other = edited(archive, tmp_path / f"{k}.fmu", files)
        if folder:
            with pytest.raises(AssertionError) as error:
                Fmu3(other, tmp_path / f"{k}").instance()
            text = str(error.value)
        else:
            instance = Fmu(other, tmp_path / f"{k}").instance()
            assert instance.component is None
            text = instance.messages[-1][-1]
        for word in [*words, "resources"]:
            assert word in text, text


def test_what_is_not_there_is_compiled_in(fmu_dir, tmp_path):
    archive = fmu_dir / "Emla.fmu"
    gone = Fmu(edited(archive, tmp_path / "Gone.fmu", {MACHINE: None}), tmp_path / "gone")
    instance = gone.instance(logging=True).start()
    assert instance.get("R_s") == 0.2
    assert any("there is no `reference_machine.json`" in text and "compiled in is used" in text for *_, text in instance.messages)
    instance.free()
    for resources in (None, "file:///nowhere/resources"):
        instance = gone.instance(resources=resources, logging=True).start()
        assert instance.get("R_s") == 0.2
        assert not any("compiled in" in text for *_, text in instance.messages)
        instance.free()
