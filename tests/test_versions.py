"""The coupled machine in both versions of FMI: all FMUs of 2.0, all of 3.0, and mixed give the same numbers bit for bit, in both masters."""

import numpy as np
import pytest

from fmpy_master import Master
from fmu import opened
from native import recorded
from system import BadSystem

SIGNALS = ["hdrm.zeta[1]", "hdrm.zeta[6]", "hdrm.x[2]", "hdrm.tip.position[2]", "emla_1.F", "emla_3.i_q", "controller.v_q[2]"]

#: Components that are of FMI 3.0.
MIXED = {"all": ("controller", "emla_1", "emla_2", "emla_3", "hdrm"), "plants": ("emla_1", "emla_3", "hdrm")}

#: FMUs by component.
FILES = {"controller": "Controller.fmu", "hdrm": "Hdrm.fmu"} | {f"emla_{k}": "Emla.fmu" for k in (1, 2, 3)}


@pytest.fixture(scope="module", params=["gauss-seidel", "standard"])
def schedule(request):
    return request.param


@pytest.fixture(scope="module")
def natively(fmu_dir, tmp_path_factory):
    """One second on the cubic trajectory, by the native master."""

    def run(schedule, *arguments):
        path = tmp_path_factory.mktemp("native") / "run.csv"
        return recorded(path, SIGNALS, "--system", fmu_dir / "Manipulator.ssp", "--schedule", schedule, "--stop-time", 5.0, *arguments)

    return run


@pytest.fixture(scope="module")
def expected(natively, schedule):
    found = natively(schedule)
    assert np.ptp(found[:, SIGNALS.index("hdrm.x[2]")]) > 1e-3, "nothing moved"
    return found


def test_natively_all_of_fmi_3(natively, schedule, expected):
    np.testing.assert_array_equal(natively(schedule, "--fmi", "3"), expected)


@pytest.mark.parametrize("components", list(MIXED.values()), ids=MIXED)
def test_natively_mixed(natively, fmu_dir, schedule, expected, components):
    replaced = [f"{name}={fmu_dir / 'fmi3' / FILES[name]}" for name in components]
    found = natively(schedule, *(argument for text in replaced for argument in ("--fmu", text)))
    np.testing.assert_array_equal(found, expected)


@pytest.fixture(scope="module")
def both(fmu_dir, fmus, tmp_path_factory):
    """The FMUs of both versions; those of 3.0 by `fmi3/Emla.fmu`."""
    folder = tmp_path_factory.mktemp("fmi3")
    names = sorted(set(FILES.values()))
    return fmus | {f"fmi3/{name}": opened(fmu_dir / "fmi3" / name, folder / name) for name in names}


def by_fmpy(system, both, schedule, components=()):
    used = {name: f"fmi3/{FILES[name]}" if name in components else file for name, file in system.components.items()}
    was, system.components = system.components, used
    try:
        master = Master(system, both, schedule=schedule)
        _, rows = master.record(4.2, SIGNALS)
        master.free()
    finally:
        system.components = was
    return rows


@pytest.fixture(scope="module")
def expected_of_fmpy(system, both, schedule):
    return by_fmpy(system, both, schedule)


@pytest.mark.parametrize("components", list(MIXED.values()), ids=MIXED)
def test_with_fmpy(system, both, schedule, expected_of_fmpy, components):
    np.testing.assert_array_equal(by_fmpy(system, both, schedule, components), expected_of_fmpy)


def test_a_staged_exchange_without_event_mode_is_refused(system, both):
    fmu = both["fmi3/Emla.fmu"]
    fmu.description.coSimulation.hasEventMode = False
    try:
        with pytest.raises(BadSystem, match="of FMI 3.0 and has no Event Mode"):
            by_fmpy(system, both, "jacobi", ("emla_1",))
    finally:
        fmu.description.coSimulation.hasEventMode = True
