"""Parameter sets (.ssv) and variants (.ssd) of the packed system: complete, and the same runs as with options by name."""

import zipfile

import numpy as np
import pytest

from fmpy_master import ROOT, Master, addressed
from native import call, recorded
from system import System, read_set

TRAJECTORIES, MODES = ("cubic", "triangular"), ("adaptive", "modular", "pd")
VARIANTS = [f"{t}_{m}.ssd" for t in TRAJECTORIES for m in MODES]
SIGNALS = ["controller.tip_error_norm", "hdrm.x[2]", "emla_2.F", "controller.v_q[1]"]


@pytest.fixture(scope="module")
def packed(fmu_dir):
    with zipfile.ZipFile(fmu_dir / "Manipulator.ssp") as archive:
        yield {name: archive.read(name) for name in archive.namelist()}


@pytest.mark.parametrize("name", TRAJECTORIES + MODES)
def test_sets_are_packed_as_they_are(packed, name):
    assert packed[f"resources/{name}.ssv"] == (ROOT / f"system/resources/{name}.ssv").read_bytes()


@pytest.mark.parametrize("name", TRAJECTORIES + MODES)
def test_sets_hold_start_values_of_the_fmu(packed, controller, name):
    """All but the enumeration, which is the item that the set is named after."""
    for parameter, (value, _, unit) in read_set(packed[f"resources/{name}.ssv"]).items():
        variable = controller.variables[parameter]
        assert variable.causality == "parameter"
        if variable.type == "Enumeration":
            assert [item.name for item in variable.declaredType.items if int(item.value) == value] == [name]
        else:
            assert (value, unit) == (float(variable.start), variable.unit)


@pytest.mark.parametrize("name", VARIANTS)
def test_variants_are_the_structure_with_two_sets_bound(fmu_dir, system, controller, name):
    variant = System.read(fmu_dir / "Manipulator.ssp", name)
    assert (variant.components, variant.connectors, variant.links) == (system.components, system.connectors, system.links)
    trajectory, mode = name.removesuffix(".ssd").split("_")
    assert variant.parameters["controller"] == system.parameters["controller"] | sets(trajectory, mode)
    assert {c: p for c, p in variant.parameters.items() if c != "controller"} == {
        c: p for c, p in system.parameters.items() if c != "controller"
    }
    instance = controller.running(trajectory=trajectory)
    assert variant.stop == instance.get("motion_end")
    instance.free()


def sets(*names):
    return {n: v for name in names for n, v in read_set((ROOT / f"system/resources/{name}.ssv").read_bytes()).items()}


def rows(system, fmus, settings=None):
    master = Master(system, fmus, settings)
    found = master.record(4.5, SIGNALS)[1]
    master.free()
    return found


def test_a_variant_is_the_same_run_as_options_by_name_in_fmpy(fmu_dir, fmus, system):
    """To the last bit, from the variant, from the sets, and from numbers by name; and not the run of the default."""
    by_name = rows(system, fmus, {"controller": {"trajectory": 2, "mode": 3}})
    variant = System.read(fmu_dir / "Manipulator.ssp", "triangular_pd.ssd")
    np.testing.assert_array_equal(rows(variant, fmus), by_name)
    np.testing.assert_array_equal(rows(system, fmus, addressed(system, fmus, sets("triangular", "pd"))), by_name)
    assert np.abs(rows(system, fmus) - by_name).max() > 1e-3


@pytest.mark.parametrize("trajectory, mode", [("triangular", "pd"), ("triangular", "modular"), ("cubic", "adaptive")])
def test_a_set_is_the_same_run_as_options_by_name_in_the_native_master(fmu_dir, tmp_path, trajectory, mode):
    def run(*options, **settings):
        path = tmp_path / "run.csv"
        return recorded(path, SIGNALS, "--system", fmu_dir / "Manipulator.ssp", "--stop-time", 4.5, *options, settings=settings)

    by_name = run(controller={"trajectory": trajectory, "mode": mode})
    sets = [option for name in (trajectory, mode) for option in ("--parameters", f"resources/{name}.ssv")]
    np.testing.assert_array_equal(run(*sets), by_name)
    np.testing.assert_array_equal(run("--variant", f"{trajectory}_{mode}.ssd"), by_name)
    assert np.array_equal(run(), by_name) == ((trajectory, mode) == ("cubic", "adaptive"))
    assert len(by_name) == 4501


def native(fmu_dir, *options):
    return call("cosim", "run", "--quiet", "--system", fmu_dir / "Manipulator.ssp", *options)


SET = (ROOT / "system/resources/triangular.ssv").read_text()


@pytest.mark.parametrize("right, wrong, expected", [
    ('Integer value="2"', 'Enumeration value="circle"', ["controller.trajectory", "`circle`", "cubic (1), triangular (2), external (3)"]),
    ('value="2"', 'value="7"', ["trajectory", "7"]),
    ('unit="s"', 'unit="ms"', ["`controller.settle_time` = 4 in `ms`", "it must be in the unit of the variable, `s`"]),
    ('value="4"', 'value="-4"', ["settle_time", "-4 must be from 0"]),
    ('name="settle_time"', 'name="settling"', ["no component", "`settling`"]),
    ('name="trajectory"', 'name="alpha"', ["several components", "`alpha`"]),
    ('name="trajectory"', 'name="emla_1.alfa"', ["emla_1", "`alfa`"]),
])  # fmt: skip
def test_a_wrong_set_is_refused_with_file_parameter_value_and_what_is_allowed(fmu_dir, tmp_path, right, wrong, expected):
    assert right in SET
    path = tmp_path / "wrong.ssv"
    path.write_text(SET.replace(right, wrong))
    done = native(fmu_dir, "--parameters", path)
    assert done.returncode == 1
    for part in [f"parameter set `{path}`", *expected]:
        assert part in done.stderr, done.stderr


def test_missing_sets_and_variants_are_named_beside_what_there_is(fmu_dir, tmp_path):
    done = native(fmu_dir, "--parameters", "resources/circle.ssv")
    assert done.returncode == 1 and "`resources/circle.ssv`" in done.stderr
    done = native(fmu_dir, "--variant", "circle_pd.ssd")
    assert done.returncode == 1 and all(name in done.stderr for name in ["circle_pd.ssd", *VARIANTS]), done.stderr
    path = tmp_path / "table.ssv"
    path.write_text("time,x\n0,1\n")
    done = native(fmu_dir, "--parameters", path)
    assert done.returncode == 1 and str(path) in done.stderr and "no XML" in done.stderr
