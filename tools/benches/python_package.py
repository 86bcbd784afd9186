"""What the package costs: compared with the program, on two workers compared with one, with a worker and the scheduler killed, and compared with FMPy.

    python tools/benches/python_package.py all                     # 1000 cases; on two quiet cores about 20 minutes
    python tools/benches/python_package.py all --cases 300         # about 9 minutes
    python tools/benches/python_package.py overhead                # one of overhead, scaling, endurance, fmpy alone

`cargo xtask wheel --check` makes the environment `target/python` with the package and all that this needs. A case is the cubic motion, 24 s of
simulated time. Wall times say something on a quiet machine alone; bits are compared on any.
"""

import argparse
import resource
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import pandas

import hdrm_fmu

ROOT = Path(__file__).resolve().parents[1]


def overhead(args):
    """Both record the default signals, in turns. Processor time, since wall time on a busy machine is a matter of luck. That of the program is
    without and with its CSV, and includes loading, which `run` does once for all runs of a process."""
    ssp = str(hdrm_fmu.systems()["Manipulator"])
    hdrm_fmu.run(stop_time=0.1)
    ours, program, bare = [], [], []
    for _ in range(args.repeats):
        clock = time.process_time()
        hdrm_fmu.run()
        ours.append(time.process_time() - clock)
        with tempfile.TemporaryDirectory() as folder:
            for times, csv in ((bare, []), (program, ["--csv", f"{folder}/run.csv"])):
                before = _children()
                subprocess.run([args.program, "run", "--quiet", "--system", ssp, *csv], capture_output=True, check=True)
                times.append(_children() - before)
    best = lambda times: f"least {min(times):.3f} s, median {statistics.median(times):.3f} s"
    print(f"processor time of run: {best(ours)}; of the program: {best(bare)}; with CSV: {best(program)}")
    for what, times in (("program", bare), ("program with CSV", program)):
        print(f"run compared with the {what}, least processor time: {100 * (min(ours) / min(times) - 1):+.1f} %", flush=True)


def _children():
    """Processor time of all programs that have ended, s."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


CASES = {"hdrm.inertia_scale": (0.8, 1.2)}
CLUSTER = {"threads_per_worker": 1, "processes": True, "host": "127.0.0.1", "dashboard_address": None}


def scaling(args):
    """Cases of the whole motion on one worker and on two, in turns, so that what else the machine does meets both alike. The workers are
    processes on loopback addresses; their processor time is what a case costs wherever it runs. Each turn has a cluster of its own, since
    workers, nannies and scheduler of an idle one take some hundredths of a core each. Both tables must be equal, bit for bit."""
    from distributed import Client, LocalCluster

    wall, processor, memory, tables = {1: 0.0, 2: 0.0}, {1: 0.0, 2: 0.0}, {1: [], 2: []}, {1: [], 2: []}
    cases = hdrm_fmu.random(args.cases, 1, CASES)
    slices = [cases.iloc[k : k + args.slice] for k in range(0, len(cases), args.slice)]
    with tempfile.TemporaryDirectory() as folder:
        for k, part in enumerate(slices):
            for workers in wall:
                with LocalCluster(n_workers=workers, **CLUSTER) as cluster, Client(cluster) as client:
                    hdrm_fmu.sweep(cases.iloc[: 8 * workers], out=f"{folder}/warm-{workers}-{k}", client=client, progress=False)
                    before = client.run(_usage).values()
                    clock = time.perf_counter()
                    tables[workers].append(hdrm_fmu.sweep(part, out=f"{folder}/{workers}-{k}", client=client, progress=False))
                    wall[workers] += time.perf_counter() - clock
                    after = client.run(_usage).values()
                processor[workers] += sum(c for c, _ in after) - sum(c for c, _ in before)
                memory[workers].append([max(m for _, m in used) / 1e6 for used in (before, after)])
    for workers, of in memory.items():
        grown = max(after - before for before, after in of)
        print(
            f"{workers} worker(s): {len(cases)} cases in {wall[workers]:.1f} s, {len(cases) / wall[workers]:.3f} cases/s, "
            f"{processor[workers] / len(cases):.3f} s of processor time a case; a worker held {max(max(m) for m in of):.0f} MB at most, "
            f"{grown:.0f} MB more after {len(slices[0])} cases than after 8"
        )
    print(f"throughput of two workers: {wall[1] / wall[2] / 2:.3f} of twice one; processor time a case: {processor[2] / processor[1]:.3f} of that of one")
    one, two = (pandas.concat(tables[workers], ignore_index=True) for workers in (1, 2))
    pandas.testing.assert_frame_equal(one, two, check_exact=True)
    print(f"all {len(one)} rows of both are equal bit for bit", flush=True)
    return one


def _usage():
    """Processor time, s, and resident memory, bytes, of a worker."""
    import psutil

    process = psutil.Process()
    times = process.cpu_times()
    return times.user + times.system, process.memory_info().rss


def endurance(args, alone=None):
    """A sweep on two workers of which one is killed after a third of the cases; after two thirds the scheduler is killed and started again.
    The table must be complete, and equal bit for bit to `alone`, the table of one worker, and to calls of `run`, one after the other."""
    sys.path.insert(0, str(ROOT / "python/tests"))
    from conftest import Cluster

    cases = hdrm_fmu.random(args.cases, 1, CASES)
    cluster, tables = Cluster(), []
    cluster.start_workers(2)
    try:
        with tempfile.TemporaryDirectory() as folder, cluster.client() as client:
            client.wait_for_workers(2, timeout=120)
            thread = threading.Thread(target=lambda: tables.append(hdrm_fmu.sweep(cases, out=folder, client=client, progress=False)))
            clock = time.perf_counter()
            thread.start()
            _wait_for_rows(folder, len(cases) // 3, thread)
            cluster.workers[0].kill()
            cluster.start_workers(1)
            print(f"a worker killed after {time.perf_counter() - clock:.0f} s", flush=True)
            _wait_for_rows(folder, 2 * len(cases) // 3, thread)
            cluster.scheduler.kill()
            cluster.scheduler.wait()
            cluster.start_scheduler()
            cluster.start_workers(2)
            print(f"the scheduler killed and started again after {time.perf_counter() - clock:.0f} s", flush=True)
            thread.join()
            print(f"{len(cases)} cases after {time.perf_counter() - clock:.0f} s", flush=True)
    finally:
        cluster.close()
    (table,) = tables
    assert len(table) == len(cases) and (table["verdict"] == "good").all()
    if alone is not None:
        pandas.testing.assert_frame_equal(table, alone, check_exact=True)
        print(f"complete; all {len(table)} rows are equal to those of one worker, bit for bit", flush=True)
    every = args.every if alone is not None else 1
    some = table.iloc[::every]
    for row in some.to_dict("records"):
        run = hdrm_fmu.run(settings={"hdrm.inertia_scale": row["hdrm.inertia_scale"]}, signals=[]).attrs
        different = [name for name, value in row.items() if name in run and run[name] != value]
        assert not different and row["tip_rmse"] == run["tip_rmse"], (row, different)
    print(f"complete; {len(some)} of {len(table)} rows are equal to calls of `run`, one after the other, bit for bit", flush=True)


def _wait_for_rows(folder, count, thread):
    while sum(len(pandas.read_parquet(part, columns=["key"])) for part in Path(folder).glob("part-*.parquet")) < count:
        assert thread.is_alive(), "the sweep has ended too early"
        time.sleep(1.0)


def _with_fmpy(scale):
    """The same case on the tests' FMPy master."""
    sys.path.insert(0, str(ROOT / "tests"))
    from fmpy_master import Master
    from fmu import Fmu
    from system import System as Structure

    with tempfile.TemporaryDirectory() as folder:
        structure = Structure.read(ROOT / "system/SystemStructure.ssd")
        files = set(structure.components.values())
        fmus = {file: Fmu(hdrm_fmu.fmus()[Path(file).stem], Path(folder) / file) for file in files}
        master = Master(structure, fmus, {"hdrm": {"inertia_scale": scale}})
        times, rows = master.record(24.25, ["controller.tip_error_norm"])
        master.free()
    return hdrm_fmu.tip_error(times, rows[:, 0], 0.0)["tip_max_whole"]


def fmpy(args):
    """Throughput compared with FMPy with Dask, on the same cluster and cases."""
    from distributed import Client, LocalCluster

    cases = hdrm_fmu.random(args.fmpy_cases, 1, CASES)
    with LocalCluster(n_workers=2, **CLUSTER) as cluster, Client(cluster) as client, tempfile.TemporaryDirectory() as folder:
        hdrm_fmu.sweep(cases.iloc[:2], out=f"{folder}/warm", client=client, progress=False, stop_time=0.1)
        clock = time.perf_counter()
        table = hdrm_fmu.sweep(cases, out=f"{folder}/all", client=client, progress=False)
        ours = time.perf_counter() - clock
        clock = time.perf_counter()
        theirs = client.gather(client.map(_with_fmpy, cases["hdrm.inertia_scale"].tolist()))
        others = time.perf_counter() - clock
    assert max(abs(table["tip_max_whole"] - theirs)) < 1e-9
    print(f"{len(cases)} cases on two workers: {ours:.1f} s, FMPy {others:.1f} s: {others / ours:.1f} times the throughput", flush=True)


def all_of_it(args):
    """Everything, each result as soon as it is there."""
    overhead(args)
    alone = scaling(args)
    endurance(args, alone)
    fmpy(args)


WHAT = {"overhead": overhead, "scaling": scaling, "endurance": endurance, "fmpy": fmpy, "all": all_of_it}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=WHAT)
    parser.add_argument("--program", default=str(ROOT / "target/release/hdrm-fmu"))
    parser.add_argument("--repeats", type=int, default=7, help="runs of `overhead`")
    parser.add_argument("--cases", type=int, default=1000, help="of `scaling` and `endurance`")
    parser.add_argument("--slice", type=int, default=250, help="cases in a turn of `scaling`, each a sweep of its own")
    parser.add_argument("--every", type=int, default=20, help="of `all`: which rows are compared with calls of `run` too, 20: every twentieth")
    parser.add_argument("--fmpy-cases", type=int, default=20, help="of `fmpy`")
    args = parser.parse_args()
    WHAT[args.what](args)


if __name__ == "__main__":
    main()
