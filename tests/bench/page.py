"""How fast the page's engine is in Chromium beside `cosim`, on one core, in turn: coupled system, and the real world with one ghost.

    MACHINE_PAGE=target/web/machine.html FMU_DIR=target/fmu python tests/bench/page.py [ROUNDS]

Prints a line of JSON for each: simulated time by the clock, and by processor time of all processes, which other programs disturb less;
median and best of the rounds. All engines together make as many times real time; the ratio is that of the medians by processor time.
"""

import json
import os
import resource
import statistics
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from conftest import FMU_DIR  # noqa: E402
from native import call  # noqa: E402
from test_page_engine import opened, told, unpack  # noqa: E402

SECONDS = 20
# Each engine has a worker of its own; ghosts run at the same time.
RUN = """
  window.engines ??= {};
  const own = (window.engines.KEY ??= await Promise.all(Array.from({ length: COUNT }, async () => {
    const engine = await open(archives["system.ssp"]);
    await engine.restart({ structure: "STRUCTURE" });
    await engine.watch(["controller.tip_error_norm", "hdrm.tip.position[1]", "emla_1.F"]);
    await engine.advance(1);
    return engine;
  })));
  const begin = performance.now();
  await Promise.all(own.map((engine) => engine.advance(SECONDS)));
  return (SECONDS * 1000) / (performance.now() - begin);
"""
SYSTEMS = (("Manipulator", "SystemStructure.ssd", 1), ("Real", "Real.ssd", 2))


def native(system):
    """Times real time of `cosim`, by the clock and by processor time without what a start takes."""

    def processor(seconds):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = call("cosim", "bench", "--json", "--repeat", "1", "--system", FMU_DIR / f"{system}.ssp", "--stop-time", seconds)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, json.loads(done.stdout)["real_time_factor"]["best"]

    (start, _), (took, factor) = processor(0.001), processor(SECONDS)
    return factor, SECONDS / (took - start)


def processor_of(root):
    """Processor time of a process and all that it has started, s."""
    parents, times = {}, {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        parents[int(entry.name)], times[int(entry.name)] = int(fields[1]), sum(map(int, fields[11:13]))
    own = {root}
    while more := {pid for pid, parent in parents.items() if parent in own} - own:
        own |= more
    return sum(times.get(pid, 0) for pid in own) / os.sysconf("SC_CLK_TCK")


def in_page(chrome, script, count):
    """The same of `count` engines in the page."""
    before = processor_of(chrome.service.process.pid)
    factor = told(chrome, script)
    return count * factor, count * SECONDS / (processor_of(chrome.service.process.pid) - before)


def main():
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    os.sched_setaffinity(0, {0})
    seen = {system: ([], []) for system, *_ in SYSTEMS}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        unpack(folder)
        chrome = opened(folder)
        for _ in range(rounds):
            for system, structure, count in SYSTEMS:
                script = RUN.replace("KEY", system).replace("STRUCTURE", structure).replace("COUNT", str(count)).replace("SECONDS", str(SECONDS))
                seen[system][0].append(in_page(chrome, script, count))
                seen[system][1].append(native(system))
        chrome.quit()
    for system, _, count in SYSTEMS:
        row = {"system": system, "engines": count}
        for who, factors in zip(("page", "cosim"), seen[system]):
            for what, numbers in zip(("clock", "processor"), zip(*factors)):
                row[f"{who} by {what}"] = {"median": round(statistics.median(numbers), 1), "best": round(max(numbers), 1)}
        row["ratio"] = round(row["page by processor"]["median"] / row["cosim by processor"]["median"], 2)
        print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
