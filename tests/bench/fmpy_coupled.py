"""Cost of a coupled step of 1 ms with the FMPy master of the tests: the same FMUs, driven from Python.

    python tests/bench/fmpy_coupled.py FMU_DIR

Prints a line of JSON.
"""

import json
import statistics
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from fmpy_master import Master  # noqa: E402
from fmu import Fmu  # noqa: E402
from system import System  # noqa: E402

BATCHES, STEPS = 5, 200


def main():
    system = System.read(ROOT / "system/SystemStructure.ssd")
    with tempfile.TemporaryDirectory() as folder:
        fmus = {f: Fmu(Path(sys.argv[1]) / Path(f).name, Path(folder) / Path(f).name) for f in set(system.components.values())}
        master = Master(system, fmus)
        times = []
        for _ in range(BATCHES):
            start = time.perf_counter()
            for _ in range(STEPS):
                master.step()
            times.append(1e9 * (time.perf_counter() - start) / STEPS)
        master.free()
    name = f"coupled step of 1 ms, FMPy {version('FMPy')} master"
    print(json.dumps({"name": name, "unit": "ns", "median": round(statistics.median(times), 1), "least": round(min(times), 1)}))


if __name__ == "__main__":
    main()
