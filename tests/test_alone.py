"""Each FMU by itself: `cosim run X.fmu` gives the bits of FMPy's slave driven by hand."""

import numpy as np
import pytest

from alone import by_cosim, by_fmpy, outputs
from conftest import NAMES, WORLD
from fmu import opened
from importers import driven
from native import program

H, STEPS = 1e-3, 200



#: Inputs over time, and start values, by model; the others are left alone.
INPUTS = {name: lambda t, name=name: driven(name, t) for name in NAMES}
INPUTS |= {
    "Rig": lambda t: driven("Emla", t),
    "DcLink": lambda t: {"i_load[1]": 20.0 * t, "i_load[2]": -3.0 + 40.0 * t},
    "Sensors": lambda t: {"x[1]": 0.3 + 0.01 * t, "i_q[2]": 5.0 * t},
}
SETTINGS = {"Emla": {"alpha": 0.2}}


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("model", [*NAMES, *WORLD])
def test_an_fmu_alone_is_that_of_fmpy(fmu_dir, tmp_path, model, version):
    path = (fmu_dir if version == 2 else fmu_dir / "fmi3") / f"{model}.fmu"
    fmu = opened(path, tmp_path)
    known = [name for name in INPUTS[model](0.0) if name in fmu.variables]
    inputs = (lambda t: {name: INPUTS[model](t)[name] for name in known}) if known else None
    assert known, "nothing drives it"
    options = {"inputs": inputs, "settings": SETTINGS.get(model)}
    theirs = by_fmpy(fmu, 0.0, H, STEPS, **options)
    ours = by_cosim(program("cosim"), path, outputs(fmu), 0.0, H, STEPS, **options)
    assert theirs.shape == (STEPS + 1, len(outputs(fmu)))
    np.testing.assert_array_equal(ours.view("u8"), theirs.view("u8"))
    assert (np.ptp(theirs, axis=0) > 0.0).sum() > len(known) / 2, "next to nothing happens"
