"""What the package costs: beside the program, on two workers beside one, and beside FMPy. For a quiet machine.

    python benches/python_package.py overhead --program target/release/hdrm-fmu
    python benches/python_package.py scaling --cases 1000
    python benches/python_package.py endurance --cases 1000
    python benches/python_package.py fmpy --cases 20
"""

import argparse
import contextlib
import resource
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

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
        print(f"run beside the {what}, least processor time: {100 * (min(ours) / min(times) - 1):+.1f} %")


def _children():
    """Processor time of all programs that have ended, s."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


CASES = {"hdrm.inertia_scale": (0.8, 1.2)}
CLUSTER = {"threads_per_worker": 1, "processes": True, "host": "127.0.0.1", "dashboard_address": None}


def scaling(args):
    """Cases of the whole motion on one worker and on two, in turns, so that what else the machine does meets both alike. The workers are
    processes on loopback addresses; their processor time is what a case costs wherever it runs."""
    from distributed import Client, LocalCluster

    wall, processor, memory = {1: 0.0, 2: 0.0}, {1: 0.0, 2: 0.0}, {}
    cases = hdrm_fmu.random(args.cases, 1, CASES)
    slices = [cases.iloc[k : k + args.slice] for k in range(0, len(cases), args.slice)]
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as open_ones:
        clients = {}
        for workers in wall:
            cluster = open_ones.enter_context(LocalCluster(n_workers=workers, **CLUSTER))
            clients[workers] = open_ones.enter_context(Client(cluster))
            hdrm_fmu.sweep(cases.iloc[: 2 * workers], out=f"{folder}/warm{workers}", client=clients[workers], progress=False)
            memory[workers] = sum(m for _, m in clients[workers].run(_usage).values())
        for k, part in enumerate(slices):
            for workers, client in clients.items():
                before = sum(c for c, _ in client.run(_usage).values())
                clock = time.perf_counter()
                hdrm_fmu.sweep(part, out=f"{folder}/{workers}-{k}", client=client, progress=False)
                wall[workers] += time.perf_counter() - clock
                processor[workers] += sum(c for c, _ in client.run(_usage).values()) - before
        for workers, client in clients.items():
            grown = (sum(m for _, m in client.run(_usage).values()) - memory[workers]) / 1e6 / workers
            print(
                f"{workers} worker(s): {len(cases)} cases in {wall[workers]:.1f} s, {len(cases) / wall[workers]:.3f} cases/s, "
                f"{processor[workers] / len(cases):.3f} s of processor time a case, memory of a worker grew by {grown:.1f} MB"
            )
    print(f"throughput of two workers: {wall[1] / wall[2] / 2:.2f} of twice one; processor time a case: {processor[2] / processor[1]:.3f} of that of one")


def _usage():
    """Processor time, s, and resident memory, bytes, of a worker."""
    import psutil

    process = psutil.Process()
    times = process.cpu_times()
    return times.user + times.system, process.memory_info().rss


def endurance(args):
    """A sweep on two workers of which one is killed after a third of the cases; after two thirds the scheduler is killed and started again.
    The table must be complete, and equal to serial runs bit for bit."""
    sys.path.insert(0, str(ROOT / "python/tests"))
    from conftest import Cluster

    cases = hdrm_fmu.random(args.cases, 1, CASES)
    cluster, tables = Cluster(), []
    cluster.start_workers(2)
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
    cluster.close()
    (table,) = tables
    assert len(table) == len(cases) and (table["verdict"] == "good").all()
    some = table.iloc[:: args.every]
    for row in some.itertuples():
        alone = hdrm_fmu.run(settings={"hdrm.inertia_scale": row[1]}, signals=[]).attrs
        for name in ("tip_rmse", "tip_max", "tip_rmse_whole", "residual_peak", "residual_energy"):
            assert getattr(row, name) == alone[name], (row, name)
    print(f"complete; {len(some)} of {len(table)} rows compared with serial runs: equal bit for bit")


def _wait_for_rows(folder, count, thread):
    import pandas

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
    """Throughput beside FMPy with Dask, on the same cluster and cases."""
    from distributed import Client, LocalCluster

    cases = hdrm_fmu.random(args.cases, 1, CASES)
    with LocalCluster(n_workers=2, **CLUSTER) as cluster, Client(cluster) as client, tempfile.TemporaryDirectory() as folder:
        hdrm_fmu.sweep(cases.iloc[:2], out=f"{folder}/warm", client=client, progress=False, stop_time=0.1)
        clock = time.perf_counter()
        table = hdrm_fmu.sweep(cases, out=f"{folder}/all", client=client)
        ours = time.perf_counter() - clock
        clock = time.perf_counter()
        theirs = client.gather(client.map(_with_fmpy, cases["hdrm.inertia_scale"].tolist()))
        others = time.perf_counter() - clock
    assert max(abs(table["tip_max_whole"] - theirs)) < 1e-9
    print(f"{args.cases} cases: {ours:.1f} s, FMPy {others:.1f} s: {others / ours:.1f} times the throughput")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("overhead", "scaling", "endurance", "fmpy"))
    parser.add_argument("--program", default=str(ROOT / "target/release/hdrm-fmu"))
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--cases", type=int, default=20)
    parser.add_argument("--slice", type=int, default=50, help="cases in a turn of `scaling`")
    parser.add_argument("--every", type=int, default=1, help="which rows `endurance` compares with serial runs: 1 all, 5 every fifth")
    args = parser.parse_args()
    globals()[args.what](args)


if __name__ == "__main__":
    main()
