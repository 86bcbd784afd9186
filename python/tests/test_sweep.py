"""Sweeps on clusters of separate processes: complete, equal bit for bit, resumed, and no harm done by bad input."""

import json
import os
import random
import shutil
import subprocess
import sys
import threading
import time
import zipfile

import pandas
import pytest

import hdrm_fmu
from hdrm_fmu import BadInput, grid, sweep, sweeping
from hdrm_fmu.store import read_table, write_table
from hdrm_fmu.tasks import Case, case_key, run_case

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
    write_table(file, read_table(file).assign(tip_rmse=-1.0))
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


SET = """<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="s"><ssv:Parameters>
<ssv:Parameter name="hdrm.inertia_scale"><ssv:Real value="{}"/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet>"""


def repacked(system, name):
    """Change a byte of a file in a packed system that no number depends on: its archive's comment."""
    with zipfile.ZipFile(system) as archive:
        entries = [(entry, archive.read(entry)) for entry in archive.infolist()]
    with zipfile.ZipFile(system, "w") as archive:
        for entry, content in entries:
            if entry.filename.endswith(name):
                end = content.rfind(b"PK\5\6")
                content = content[: end + 20] + b"\1\0!"
            archive.writestr(entry, content)


@pytest.fixture
def own_files(tmp_path):
    """A system, a parameter set, a machine file that extends another one, and a path, in a folder of their own."""
    shutil.copy(hdrm_fmu.systems()["Manipulator"], tmp_path / "system.ssp")
    (tmp_path / "set.ssv").write_text(SET.format(1.0))
    shutil.copy(hdrm_fmu.parameters()["reference_machine"], tmp_path / "base.json")
    (tmp_path / "machine.json").write_text(json.dumps({"extends": "base.json"}))
    points = [[4.0, 1.5, 0.0], [4.1, 1.5, 0.0]]
    pandas.DataFrame(points, columns=["x", "y", "z"]).to_csv(tmp_path / "path.csv", index=False)
    return tmp_path


def set_inertia(folder):
    (folder / "set.ssv").write_text(SET.format(1.3))


def extend_machine(folder):
    text = json.loads((folder / "base.json").read_text())
    text["bodies"]["PL"]["mass"] *= 1.5
    (folder / "base.json").write_text(json.dumps(text))


def move_path(folder):
    (folder / "path.csv").write_text((folder / "path.csv").read_text().replace("4.1", "4.2"))


def change_fmu(folder):
    repacked(folder / "system.ssp", "Hdrm.fmu")


def own_sweep(folder, out, **options):
    system = hdrm_fmu.System(folder / "system.ssp", parameters=[folder / "set.ssv"], step=1e-3)
    cases = pandas.DataFrame({"hdrm.machine_file": [str(folder / "machine.json")], "waypoints": [str(folder / "path.csv")]})
    settings = {**QUICK["settings"], "path_check": False}
    return sweep(cases, out=out, system=system, **{**QUICK, "settings": settings, **options})


@pytest.mark.parametrize("edit", [set_inertia, extend_machine, move_path, change_fmu])
def test_an_edited_file_is_another_case(two_workers, own_files, edit):
    """The cluster remembers neither the result nor the system; the file keeps its size and its time."""
    first = own_sweep(own_files, own_files / "out", client=two_workers)
    times = {file: file.stat() for file in own_files.iterdir() if file.is_file()}
    edit(own_files)
    for file, before in times.items():
        os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))
    fresh = own_sweep(own_files, own_files / "fresh", client=two_workers)
    assert first["key"][0] != fresh["key"][0]
    alone = own_sweep(own_files, own_files / "alone")
    pandas.testing.assert_frame_equal(fresh, alone, check_exact=True)
    # The path begins later than the run ends, and the FMU differs in a comment only.
    assert (fresh["tip_rmse"] != first["tip_rmse"]).all() == (edit in (set_inertia, extend_machine))
    there = files(own_files / "out")
    if edit in (set_inertia, change_fmu):
        with pytest.raises(BadInput, match="parameter sets or its FMUs had other contents"):
            own_sweep(own_files, own_files / "out", client=two_workers)
        assert files(own_files / "out") == there
    else:
        with pytest.warns(UserWarning, match="also holds 1 results of these cases"):
            again = own_sweep(own_files, own_files / "out", client=two_workers)
        pandas.testing.assert_frame_equal(again, fresh, check_exact=True)
        assert set(read_table(own_files / "out/results.parquet")["key"]) == {first["key"][0], fresh["key"][0]}


def test_a_system_is_read_again_after_an_edit(own_files):
    """Of the same size, with the time of before."""
    start = lambda: hdrm_fmu.System(own_files / "system.ssp", parameters=[own_files / "set.ssv"]).variables["hdrm.inertia_scale"].start
    before = (own_files / "set.ssv").stat()
    assert start() == "1.0"
    set_inertia(own_files)
    os.utime(own_files / "set.ssv", ns=(before.st_atime_ns, before.st_mtime_ns))
    assert start() == "1.3"


def test_a_key_is_of_contents_and_options(own_files, monkeypatch):
    """Each option in turn changes it; folders and the order of values do not."""
    spec = {"world": None, "path": str(own_files / "system.ssp"), "variant": None, "parameters": [str(own_files / "set.ssv")], "machine": None}
    spec |= {"step": 1e-3, "schedule": "gauss-seidel", "signals": None, "interval": None, "stop_time": 0.05, "max_error": None, "metrics": []}
    values = {"controller.mode": "pd", "hdrm.payload.mass": "110"}
    key = lambda values=values, seed=None, follow=None, **other: case_key({**spec, **other}, Case(values, seed, follow))
    machine = (own_files / "base.json").read_text()
    cube = hdrm_fmu.paths.tip_path("iso9283-cube")
    others = [key({**values, "hdrm.payload.mass": "120"}), key({"controller.mode": "pd"}), key(seed=1), key(follow=cube), key(machine=machine)]
    others += [key(step=2e-3), key(schedule="jacobi"), key(signals=["hdrm.zeta[2]"]), key(interval=0.01), key(stop_time=0.06)]
    others += [key(max_error=1e-3), key(metrics=["tracking"]), key(parameters=[]), key(variant="triangular_pd.ssd")]
    monkeypatch.setattr("hdrm_fmu.tasks.identity", lambda: "0.0.1-0")
    others.append(key())
    monkeypatch.undo()
    assert key() not in others and len(set(others)) == len(others)
    shutil.copytree(own_files, own_files / "elsewhere")
    moved = {"path": str(own_files / "elsewhere/system.ssp"), "parameters": [str(own_files / "elsewhere/set.ssv")]}
    assert key() == key(dict(reversed(values.items()))) == key({**values, "hdrm.payload.mass": "110.0"}) == key(**moved)


def test_a_damaged_file_is_named(two_workers, tmp_path):
    """600 bits are flipped, each alone: none is read. What is there is left as it is."""
    table = sweep(CASES.iloc[:2], out=tmp_path / "d", client=two_workers, **QUICK)
    file = tmp_path / "d/results.parquet"
    whole, draw = file.read_bytes(), random.Random(46)
    assert read_table(file)["key"].tolist() == table["key"].tolist()
    assert pandas.read_parquet(file)["key"].tolist() == table["key"].tolist()
    for bit in draw.sample(range(8 * len(whole)), 600):
        damaged = bytearray(whole)
        damaged[bit // 8] ^= 1 << bit % 8
        file.write_bytes(damaged)
        with pytest.raises(BadInput, match="results.parquet` is damaged"):
            read_table(file)
    for length in (0, 7, len(whole) // 2, len(whole) - 1):
        file.write_bytes(whole[:length])
        with pytest.raises(BadInput, match="remove it to run its cases again"):
            sweep(CASES.iloc[:2], out=tmp_path / "d", client=two_workers, **QUICK)
        assert file.read_bytes() == whole[:length]
    file.unlink()
    pandas.testing.assert_frame_equal(sweep(CASES.iloc[:2], out=tmp_path / "d", client=two_workers, **QUICK), table, check_exact=True)


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
        (CASES, {"system": hdrm_fmu.System("a.ssp"), "step": 1e-3}, "step = 0.001 must be given to the `System`"),
        (CASES, {"system": hdrm_fmu.System("a.ssp"), "world": "real"}, "world = 'real' is for the manipulator"),
        (CASES, {"system": hdrm_fmu.System("a.ssp", strict=True)}, "and `strict`"),
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
        run_case("0.0.1-0", {}, None, "")


def test_a_finished_sweep_starts_no_cluster(tmp_path, monkeypatch):
    with monkeypatch.context() as m:
        m.setattr(sweeping, "_local", lambda: pytest.fail("a cluster is started"))
        with pytest.raises(pytest.fail.Exception, match="cluster"):
            sweep(CASES.iloc[[0]], out=tmp_path / "a", **QUICK)
    table = sweep(CASES.iloc[[0]], out=tmp_path / "a", **QUICK)
    monkeypatch.setattr(sweeping, "_local", lambda: pytest.fail("a cluster is started"))
    pandas.testing.assert_frame_equal(sweep(CASES.iloc[[0]], out=tmp_path / "a", **QUICK), table)


UNGUARDED = """
import sys
import hdrm_fmu

def main():
    hdrm_fmu.sweep(hdrm_fmu.grid(mode=["pd"]), out=sys.argv[1], stop_time=0.02, progress=False)

{call}
"""


@pytest.mark.parametrize(("call", "is_guarded"), [("main()", False), ('if __name__ == "__main__":\n    main()', True)])
def test_a_missing_guard_is_one_sentence(tmp_path, call, is_guarded):
    script = tmp_path / "script.py"
    script.write_text(UNGUARDED.format(call=call))
    done = subprocess.run([sys.executable, script, tmp_path / "out"], capture_output=True, text=True, timeout=120)
    assert (done.returncode == 0) == is_guarded, done.stderr
    assert (tmp_path / "out").exists() == is_guarded
    if not is_guarded:
        assert "line 8: a sweep starts processes that import this script" in done.stderr.splitlines()[-1]
        assert done.stderr.count("Traceback") == 1
