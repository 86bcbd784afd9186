"""What stops the machine holds it: drives that trip stop the others, and after a stop rods and wrist are braked."""

import numpy as np
import pytest

from native import recorded

SIGNALS = ["controller.supervisor.state", "controller.supervisor.cause", "controller.tip_error_norm"]
TIP = ["hdrm.tip.position[1]", "hdrm.tip.position[2]", "hdrm.tip.position[3]"]
TRIANGLE = ["--set", "controller.mode=adaptive_integral", "--set", "controller.trajectory=triangular"]


def stopped(path, *options, until):
    """Time of the stop, mean drift of the tip from 3 s after it to the end, m, its largest error until then, m, and the cause."""
    rows = recorded(path, SIGNALS + TIP, *options, "--stop-time", until)
    stop = int(np.argmax(rows[:, 0] >= 5))
    assert stop > 0 and rows[-1, 0] == 7, rows[-1, :2]
    ends = [rows[stop + 3000 : stop + 3500, 3:].mean(axis=0), rows[-500:, 3:].mean(axis=0)]
    return stop * 1e-3, np.linalg.norm(ends[1] - ends[0]), rows[: stop + 3000, 2].max(), rows[-1, 1]


@pytest.mark.parametrize("payload", [0, 300])
def test_the_wrist_is_held_after_a_stop(fmu_dir, tmp_path, payload):
    """A drive that reports a trip brakes all; without brakes at the wrist the tip crept 75 mm in 20 s."""
    options = ["--system", fmu_dir / "Real.ssp", *TRIANGLE, "--set", f"hdrm.payload.mass={payload}"]
    time, drift, error, cause = stopped(tmp_path / "run.csv", *options, "--fault", "controller.tripped[2]=override:true@7..7.1", until=16)
    print(f"{payload} kg: stopped at {time} s, {1e3 * error:.2f} mm, drift {1e3 * drift:.3f} mm in 6 s")
    assert 7.0 <= time < 7.005 and cause == 4
    assert drift < 0.3e-3 and error < 40e-3


def test_a_tripped_drive_stops_the_others(fmu_dir, tmp_path):
    """One drive of three that share a link trips alone: the others drove on for 432 mm."""
    options = ["--system", fmu_dir / "Electric.ssp", "--variant", "as_built.ssd", "--fault", "emla_2.v_dc=override:300@7..7.2"]
    time, drift, error, cause = stopped(tmp_path / "run.csv", *options, until=14)
    print(f"stopped at {time} s, {1e3 * error:.2f} mm, drift {1e3 * drift:.3f} mm in 4 s")
    assert 7.0 <= time < 7.005 and cause == 4
    assert drift < 0.2e-3 and error < 40e-3
