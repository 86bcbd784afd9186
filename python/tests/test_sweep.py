"""Sweeps on clusters of separate processes: complete, equal bit for bit, resumed, and no harm done by bad input."""

import json
import os
import threading
import time

import pandas
import pytest

import hdrm_fmu
from hdrm_fmu import BadInput, grid, sweep, sweeping
from hdrm_fmu.tasks import run_case

QUICK = {"stop_time": 0.05, "settings": {"settle_time": 0.01}, "progress": False}
CASES = grid(mode=["adaptive", "pd"], **{"hdrm.inertia_scale": [0.8, 0.9, 1.1]})


def serial(cases, **options):
    """The same by calls of `run`, one after the other."""
    rows = []
    for row in cases.to_dict("records"):
        data = hdrm_fmu.run(**{**options, "signals": [], "settings": {**options["settings"], **row}})
        rows.append({**row, "tip_rmse": data.attrs["tip_rmse"], "tip_max": data.attrs["tip_max"], "verdict": data.attrs["verdict"]})
    return pandas.DataFrame(rows)


def files(folder):
    return {path.name: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_sweep_is_the_serial_run_and_repeats_nothing(two_workers, tmp_path):
    quick = {**QUICK, "client": two_workers}
    part = sweep(CASES.iloc[[4, 1]], out=tmp_path / "a", **quick)
    assert len(part) == 2
    before = (tmp_path / "a/results.parquet").stat().st_mtime_ns
    table = sweep(CASES, out=tmp_path / "a", **quick)
    expected = serial(CASES, stop_time=0.05, settings=QUICK["settings"])
    pandas.testing.assert_frame_equal(table[expected.columns], expected, check_exact=True)
    assert (tmp_path / "a/results.parquet").stat().st_mtime_ns > before
    # Cases that are there are not run again: what was altered by hand is still there.
    file = tmp_path / "a/results.parquet"
    altered = pandas.read_parquet(file).assign(tip_rmse=-1.0)
    altered.to_parquet(file, index=False)
    assert (sweep(CASES, out=tmp_path / "a", **quick)["tip_rmse"] == -1.0).all()
    # Another order gives the same rows.
    shuffled = sweep(CASES.iloc[::-1], out=tmp_path / "b", **quick).iloc[::-1].reset_index(drop=True)
    pandas.testing.assert_frame_equal(shuffled, table, check_exact=True)


def test_time_series_on_request(two_workers, tmp_path):
    table = sweep(CASES.iloc[:2], out=tmp_path / "s", signals=["hdrm.zeta[2]"], interval=0.01, client=two_workers, **QUICK)
    series = pandas.read_parquet(tmp_path / "s/series" / f"{table['key'][0]}.parquet")
    assert list(series.columns) == ["time", "hdrm.zeta[2]"] and len(series) == 6


def test_a_case_that_fails_is_a_row_with_its_error(two_workers, tmp_path):
    cases = pandas.DataFrame({"hdrm.machine_file": ["", "/nowhere.json"]})
    cases.loc[0, "hdrm.machine_file"] = str(hdrm_fmu.parameters()["reference_machine"])
    table = sweep(cases, out=tmp_path / "f", client=two_workers, **QUICK)
    assert list(table["verdict"] == "failed") == [False, True] and table["tip_rmse"][0] > 0.0
    assert "nowhere" in table["error"][1] and pandas.isna(table["tip_rmse"][1])


def test_a_worker_that_dies_and_a_scheduler_that_is_restarted(cluster, tmp_path, monkeypatch):
    """Each after some results; the table is complete and equal to a serial run."""
    monkeypatch.setattr(sweeping, "FLUSH_ROWS", 1)
    cluster.start_workers(2)
    cases = grid(**{"hdrm.inertia_scale": [0.8 + 0.01 * k for k in range(30)]})
    quick = {**QUICK, "stop_time": 2.0}
    done = {}

    def written(least):
        deadline = time.monotonic() + 240
        while len(list((tmp_path / "d").glob("part-*.parquet"))) < least:
            assert thread.is_alive() and time.monotonic() < deadline
            time.sleep(0.002)

    with cluster.client() as client:
        client.wait_for_workers(2, timeout=120)
        thread = threading.Thread(target=lambda: done.update(table=sweep(cases, out=tmp_path / "d", client=client, **quick)))
        thread.start()
        written(1)
        cluster.workers[0].kill()
        written(4)
        cluster.scheduler.kill()
        cluster.scheduler.wait()
        assert thread.is_alive(), "the sweep must not be over before the scheduler dies"
        cluster.start_scheduler()
        cluster.start_workers(1)
        thread.join(timeout=400)
        assert not thread.is_alive()
    expected = serial(cases, stop_time=2.0, settings=QUICK["settings"])
    pandas.testing.assert_frame_equal(done["table"][expected.columns], expected, check_exact=True)


def test_an_interrupted_sweep_goes_on(two_workers, tmp_path, monkeypatch):
    """Interrupted after some results; what was written is whole, and the second call runs the rest only."""
    monkeypatch.setattr(sweeping, "FLUSH_ROWS", 1)
    ended = sweeping._results

    def interrupted(client, spec, missing):
        for k, result in enumerate(ended(client, spec, missing)):
            if k == 2:
                raise KeyboardInterrupt
            yield result

    monkeypatch.setattr(sweeping, "_results", interrupted)
    with pytest.raises(KeyboardInterrupt):
        sweep(CASES, out=tmp_path / "i", client=two_workers, **QUICK)
    assert len(list((tmp_path / "i").glob("part-*.parquet"))) == 2
    submitted = []

    def counted(client, spec, missing):
        submitted.extend(missing)
        return ended(client, spec, missing)

    monkeypatch.setattr(sweeping, "_results", counted)
    table = sweep(CASES, out=tmp_path / "i", client=two_workers, **QUICK)
    assert len(submitted) == len(CASES) - 2 and len(table) == len(CASES)
    assert not list((tmp_path / "i").glob("part-*.parquet"))


@pytest.mark.parametrize(
    ("cases", "options", "reason"),
    [
        (grid(mode=["pd", "adaptive"], **{"hdrm.inertia_scal": [1.0]}), {}, "did you mean `hdrm.inertia_scale`"),
        (pandas.DataFrame({"inertia_scale": [1.0, float("nan")]}), {}, "row 1, column `inertia_scale`"),
        (pandas.DataFrame({"inertia_scale": [1.0, -2.0]}), {}, "must be at least"),
        (pandas.DataFrame({"verdict": [1.0]}), {}, "cannot be named `verdict`"),
        (pandas.DataFrame(), {}, "no cases"),
        (CASES, {"signals": ["hdrm.zetta"]}, "did you mean"),
        (CASES, {"metrics": ("nothing",)}, "metric"),
        (CASES, {"system": "/nowhere.ssp"}, "cannot be read"),
        (pandas.DataFrame({"inertia_scale": [1.0], "hdrm.inertia_scale": [1.1]}), {}, "is given twice"),
        (pandas.DataFrame({"mode": ["adaptiv"]}), {}, "did you mean `adaptive`"),
        (CASES, {"client": "tcp://127.0.0.1:8786"}, "must be a distributed.Client"),
        (CASES, {"max_error": -1.0}, "more than 0"),
        (CASES, {"metric": ("tracking",)}, "no keyword `metric`; did you mean `metrics`"),
        (pandas.DataFrame({"waypoints": [5]}), {}, "column `waypoints`: 5 must be the path of a file"),
    ],
)
def test_bad_input_costs_nothing(cases, options, reason, tmp_path):
    """No client is made, no folder either."""
    with pytest.raises(BadInput, match=reason):
        sweep(cases, out=tmp_path / "x", **{**QUICK, **options})
    assert not (tmp_path / "x").exists()


def test_results_of_another_sweep_or_version_stay_as_they_are(two_workers, tmp_path):
    folder = tmp_path / "r"
    sweep(CASES.iloc[:1], out=folder, client=two_workers, **QUICK)
    there = files(folder)
    for cases, options in ((CASES, {"stop_time": 0.06}), (grid(mode=["pd"]), {}), (CASES, {"settings": {"settle_time": 0.02}})):
        with pytest.raises(BadInput, match="another sweep"):
            sweep(cases, out=folder, client=two_workers, **{**QUICK, **options})
    assert files(folder) == there
    manifest = json.loads((folder / "sweep.json").read_text())
    (folder / "sweep.json").write_text(json.dumps({**manifest, "version": "0.0.1-0"}))
    there = files(folder)
    with pytest.raises(BadInput, match="`version`"):
        sweep(CASES, out=folder, client=two_workers, **QUICK)
    assert files(folder) == there
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/notes.txt").write_text("mine")
    with pytest.raises(BadInput, match="other files"):
        sweep(CASES, out=tmp_path / "mine", client=two_workers, **QUICK)
    assert files(tmp_path / "mine") == {"notes.txt": b"mine"}


def test_a_worker_without_the_package_is_refused(cluster, tmp_path):
    """A worker for which the package does not exist: a folder that comes first in its path hides it."""
    (tmp_path / "hide").mkdir()
    code = "import importlib.metadata as m, importlib.abc, sys\nv = m.version\n"
    code += "def version(name):\n    if name == 'hdrm_fmu': raise m.PackageNotFoundError(name)\n    return v(name)\nm.version = version\n"
    (tmp_path / "hide/sitecustomize.py").write_text(code)
    cluster.start_workers(1, environment={"PYTHONPATH": os.fspath(tmp_path / "hide")})
    with cluster.client() as client:
        client.wait_for_workers(1, timeout=120)
        with pytest.raises(BadInput, match="no package hdrm_fmu"):
            sweep(CASES, out=tmp_path / "w", client=client, **QUICK)
    assert not (tmp_path / "w").exists()


def test_what_is_not_of_the_case_is_raised():
    with pytest.raises(RuntimeError, match="a worker has hdrm_fmu"):
        run_case("0.0.1-0", {}, None)
