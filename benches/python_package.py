"""What the package costs: beside the program, on two workers beside one, and beside FMPy. For a quiet machine.

    python benches/python_package.py overhead --program target/release/hdrm-fmu
    python benches/python_package.py scaling --cases 1000
    python benches/python_package.py fmpy --cases 20
"""

import argparse
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import hdrm_fmu

ROOT = Path(__file__).resolve().parents[1]


def overhead(args):
    """Both record the default signals; the program's time is its own, without loading, CSV included, or without any recording."""
    ssp = str(hdrm_fmu.systems()["Manipulator"])
    ours, elapsed, bare = [], [], []
    for _ in range(args.repeats):
        done = subprocess.run([args.program, "run", "--quiet", "--system", ssp], capture_output=True, text=True, check=True)
        bare.append(float(re.search(r"simulated in ([\d.]+) s", done.stdout)[1]))
        clock = time.perf_counter()
        data = hdrm_fmu.run()
        ours.append(time.perf_counter() - clock)
        elapsed.append(data.attrs["elapsed"])
        with tempfile.TemporaryDirectory() as folder:
            csv = [args.program, "run", "--quiet", "--system", ssp, "--csv", f"{folder}/run.csv"]
            done = subprocess.run(csv, capture_output=True, text=True, check=True)
            bare_csv = float(re.search(r"simulated in ([\d.]+) s", done.stdout)[1])
        args.csv.append(bare_csv)
    median = statistics.median
    print(f"program without recording {median(bare):.3f} s, with CSV {median(args.csv):.3f} s; run {median(ours):.3f} s, of it stepping {median(elapsed):.3f} s")
    print(f"run beside the program with the same signals: {100 * (median(ours) / median(args.csv) - 1):+.1f} %")


def scaling(args):
    """Cases of the whole motion on clusters of separate processes on loopback addresses; memory of the workers at begin and end."""
    from distributed import Client, LocalCluster

    rates = {}
    for workers in (1, 2):
        options = {"n_workers": workers, "threads_per_worker": 1, "processes": True, "host": "127.0.0.1", "dashboard_address": None}
        with LocalCluster(**options) as cluster, Client(cluster) as client, tempfile.TemporaryDirectory() as folder:
            cases = hdrm_fmu.random(args.cases, 1, {"hdrm.inertia_scale": (0.8, 1.2)})
            hdrm_fmu.sweep(cases.iloc[: 2 * workers], out=Path(folder) / "warm", client=client, progress=False)
            before = client.run(_memory)
            clock = time.perf_counter()
            table = hdrm_fmu.sweep(cases, out=Path(folder) / "all", client=client)
            rates[workers] = len(table) / (time.perf_counter() - clock)
            after = client.run(_memory)
            growth = max(after[w] - before[w] for w in after)
            print(f"{workers} worker(s): {rates[workers]:.2f} cases/s, memory of a worker grew by at most {growth / 1e6:.1f} MB")
    print(f"two workers: {rates[2] / (2 * rates[1]):.2f} of twice one")


def _memory():
    import psutil

    return psutil.Process().memory_info().rss


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

    cases = hdrm_fmu.random(args.cases, 1, {"hdrm.inertia_scale": (0.8, 1.2)})
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "host": "127.0.0.1", "dashboard_address": None}
    with LocalCluster(**options) as cluster, Client(cluster) as client, tempfile.TemporaryDirectory() as folder:
        clock = time.perf_counter()
        table = hdrm_fmu.sweep(cases, out=folder, client=client)
        ours = time.perf_counter() - clock
        clock = time.perf_counter()
        theirs = client.gather(client.map(_with_fmpy, cases["hdrm.inertia_scale"].tolist()))
        others = time.perf_counter() - clock
    assert max(abs(table["tip_max_whole"] - theirs)) < 1e-9
    print(f"{args.cases} cases: {ours:.1f} s, FMPy {others:.1f} s: {others / ours:.1f} times the throughput")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("overhead", "scaling", "fmpy"))
    parser.add_argument("--program", default=str(ROOT / "target/release/hdrm-fmu"))
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--cases", type=int, default=20)
    args = parser.parse_args()
    args.csv = []
    globals()[args.what](args)


if __name__ == "__main__":
    main()
