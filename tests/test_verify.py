"""`cargo fmu verify`: FMUs carry the results of their default experiment (FMI-LS-REF), and are compared with them."""

import csv
import math
import zipfile

import pytest
from fmpy import read_model_description

import traits
from conftest import FMU_DIR
from native import cargo_fmu
from test_sizes import A, TOLERANCE, W, pack

FOLDER = "extra/org.fmi-standard.fmi-ls-ref/"
SIX = ["Controller", "DcLink", "Emla", "Hdrm", "Rig", "Sensors"]
RELATED = {"parameter": ("application/x-ssp-parameter-set", "x.ssv"), "input": ("text/csv", "x_in.csv"), "result": ("text/csv", "x_out.csv")}


def with_files(fmu, path, files):
    """A copy of an FMU with other files in the folder of FMI-LS-REF."""
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            if name.removeprefix(FOLDER) not in files:
                new.writestr(name, old.read(name))
        for name, text in files.items():
            new.writestr(FOLDER + name, text)
    return path


@pytest.mark.parametrize("name", SIX)
@pytest.mark.parametrize("folder", [".", "fmi3"])
def test_the_six_carry_their_results(name, folder):
    fmu = FMU_DIR / folder / f"{name}.fmu"
    done = cargo_fmu("verify", fmu)
    assert done.returncode == 0 and f"agrees with {name}_out.csv" in done.stdout, done.stdout + done.stderr


def test_another_result_is_named(tmp_path):
    fmu = FMU_DIR / "Emla.fmu"
    with zipfile.ZipFile(fmu) as archive:
        head, *rows = archive.read(FOLDER + "Emla_out.csv").decode().splitlines()
    cells = rows[7].split(",")
    column = head.split(",").index("theta_m")
    cells[column] = str(float(cells[column]) * (1 + 1e-3) + 1e-3)
    rows[7] = ",".join(cells)
    wrong = with_files(fmu, tmp_path / "wrong.fmu", {"Emla_out.csv": "\n".join([head, *rows])})
    done = cargo_fmu("verify", wrong)
    assert done.returncode == 1 and f"t = {cells[0]} s: `theta_m`" in done.stdout and "DIFFERS" in done.stdout, done.stdout
    assert cargo_fmu("verify", wrong, "--tolerance", "2").returncode == 0
    missing = with_files(fmu, tmp_path / "missing.fmu", {"Emla_out.csv": "time,no_such\n0,1\n"})
    done = cargo_fmu("verify", missing)
    assert done.returncode == 1 and "`no_such` is no variable of the FMU" in done.stderr


def test_arrays_agree_in_every_element(tmp_path):
    """A NaN among the elements is no agreement, whatever follows it, nor are fewer elements."""
    fmu = FMU_DIR / "fmi3" / "Hdrm.fmu"
    with zipfile.ZipFile(fmu) as archive:
        head, *rows = csv.reader(archive.read(FOLDER + "Hdrm_out.csv").decode().splitlines())
    columns = [head.index(name) for name in ["x[1]", "x[2]", "x[3]"]]
    arrays = {row[0]: [row[k] for k in columns] for row in rows}

    def verify(name):
        text = "".join(f"{t},{' '.join(x)}\n" for t, x in arrays.items())
        return cargo_fmu("verify", with_files(fmu, tmp_path / name, {"Hdrm_out.csv": "time,x\n" + text}))

    done = verify("same.fmu")
    assert done.returncode == 0, done.stdout + done.stderr
    first, second, third = arrays[rows[3][0]]
    for wrong in [[first, "NaN", third], [first, second]]:
        arrays[rows[3][0]] = wrong
        done = verify(f"{len(wrong)}.fmu")
        assert done.returncode == 1 and f"t = {rows[3][0]} s: `x`" in done.stdout, done.stdout + done.stderr


def test_parameters_and_inputs_are_set(tmp_path):
    """x' = W (x_2, -x_1) from parameters, y_2 = x_2 + u/4; u = 2 t, of the last communication point, since the model has no step of its own
    for it. Names are those of elements, in both versions."""
    done = pack(tmp_path, "n=2", "m=1", "r=2")
    assert done.returncode == 0, done.stderr
    numbers = {f"A[{1 + k // 2},{1 + k % 2}]": a for k, a in enumerate(A)}
    numbers |= {"B[1,1]": 0, "B[2,1]": 0, "C[1,1]": 1, "C[1,2]": 0, "C[2,1]": 0, "C[2,2]": 1, "D[1,1]": 0, "D[2,1]": 0.25, "x0[1]": 0, "x0[2]": 1}
    each = "".join(f'<ssv:Parameter name="{name}"><ssv:Real value="{value}"/></ssv:Parameter>' for name, value in numbers.items())
    related = "".join(f'<Related type="{kind}" source="{source}" role="{role}"/>' for role, (kind, source) in RELATED.items())
    rows = [(t, math.sin(W * t), math.cos(W * t) + 0.5 * max(t - 0.1, 0.0)) for t in (k / 10 for k in range(11))]
    files = {
        "x.ssv": f'<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"><ssv:Parameters>{each}</ssv:Parameters></ssv:ParameterSet>',
        "x_in.csv": "time,u[1]\n0,0\n0.5,1\n1,2\n",
        "x_out.csv": "time,y[1],y[2]\n" + "".join(f"{t},{a!r},{b!r}\n" for t, a, b in rows),
        "fmi-ls-manifest.xml": f"<fmiReferences>{related}</fmiReferences>",
    }
    for folder in (".", "fmi3"):
        fmu = with_files(tmp_path / folder / "StateSpace.fmu", tmp_path / folder / "set.fmu", files)
        done = cargo_fmu("verify", fmu, "--tolerance", 2 * TOLERANCE)
        assert done.returncode == 0, done.stdout + done.stderr
    for folder, version in ((".", "fmi2"), ("fmi3", "fmi3")):
        refused = {"x.ssv": files["x.ssv"].replace('<ssv:Real value="0.25"/>', '<ssv:Real value="INF"/>')}
        fmu = with_files(tmp_path / folder / "StateSpace.fmu", tmp_path / folder / "refused.fmu", files | refused)
        done = cargo_fmu("verify", fmu)
        assert done.returncode == 1 and f"setting `D[2,1]` = INF gave {version}Discard" in done.stderr, done.stderr
    wrong = with_files(fmu, tmp_path / "wrong.fmu", files | {"x_in.csv": "time,u[1]\n0,0\n1,2.01\n"})
    assert cargo_fmu("verify", wrong).returncode == 1


def test_a_run_that_ends_before_the_result_does_is_no_agreement(tmp_path):
    """The integral of u = 1, which ends, discards or fails in its step to 0.5 s."""
    library = traits.compiled(tmp_path)
    for version in (2, 3):
        fmu = traits.pack(tmp_path / "traits.fmu", library, version)
        related = "".join(f'<Related type="{kind}" source="{source}" role="{role}"/>' for role, (kind, source) in RELATED.items())
        files = {
            "x_in.csv": "time,u\n0,1\n",
            "x_out.csv": "time,x\n0,0\n0.3,0.3\n1,1\n",
            "fmi-ls-manifest.xml": f"<fmiReferences>{related}</fmiReferences>",
        }
        for kind in ("good", "terminates", "discards", "fails"):
            files["x.ssv"] = traits.parameter_set({"at": 0.5, "kind": traits.TRAITS.index(kind)})
            done = cargo_fmu("verify", with_files(fmu, tmp_path / "set.fmu", files))
            if kind == "good":
                assert done.returncode == 0, done.stdout + done.stderr
            else:
                assert done.returncode == 1 and not done.stdout, done.stdout + done.stderr
                assert ("ends the simulation at t = 0.4 s" if (version, kind) == (3, "terminates") else "DoStep from t = 0.4 s") in done.stderr, done.stderr


def test_what_is_written_is_what_it_agrees_with(tmp_path):
    """All outputs of the default experiment, and nothing else, as the packed result has them: no variable deviates."""
    for folder in (".", "fmi3"):
        fmu = FMU_DIR / folder / "Sensors.fmu"
        done = cargo_fmu("verify", fmu, "--write", tmp_path / "out.csv")
        assert done.returncode == 0, done.stderr
        written = (tmp_path / "out.csv").read_text()
        outputs = [v.name for v in read_model_description(str(fmu), validate=False).modelVariables if v.causality == "output"]
        assert next(csv.reader([written.splitlines()[0]])) == ["time", *outputs]
        done = cargo_fmu("verify", with_files(fmu, tmp_path / "same.fmu", {"Sensors_out.csv": written}))
        assert done.returncode == 0 and done.stdout.endswith("largest deviation 0.00e0\n"), done.stdout
