"""How fast the page is in Chromium, in lines of JSON.

    MACHINE_PAGE=target/web/machine.html FMU_DIR=target/fmu python tests/bench/page.py [--rounds 5] [--only engine|frames|calls|hour|report|steps]

`engine`: the engine compared with `cosim`, on one core, in turn: coupled system, and the real world with one ghost. Simulated time by the clock, and
by processor time of all processes, which other programs disturb less; median and best of the rounds. All engines together make as many times
real time; the ratio is that of the medians by processor time.

`frames`: the live machine as it opens, in software rendering, at real time with three scopes: when it moved first, frames a second by the
clock, and what a frame takes of a processor, ms: in the page's process without the worker, in the process that draws, in the others; and what
a second takes in the worker. Once with the window put together by the software renderer too, as in the tests, and once by the browser's own
program, as Chromium does without a graphics processor.

`calls`: what a call of `advance` costs besides the steps: 200 calls of 0.05 s, less one of 10 s.

`hour`: the live machine over 3600 s, led by levers to and fro: memory of its script (after a collection), of engine and FMUs, and what it keeps
to look back at, after 60, 600 and 3600 s.

`report`: until the report that REPORT_PAGE names is loaded, and until its first plot, to which the reader turns then, is drawn.

`steps`: 10^6 steps of the coupled system in the page, and the memory of engine and FMUs after 10^4 steps and at the end.
"""

import argparse
import json
import os
import resource
import statistics
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from browser import chromium, run  # noqa: E402
from conftest import FMU_DIR  # noqa: E402
from native import call  # noqa: E402
from test_page_engine import PAGE, opened, told, unpack  # noqa: E402

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
# Pictures of ten seconds, and how long these were, ms.
COUNT_FRAMES = """
  return new Promise((told) => {
    const begin = performance.now();
    let count = 0;
    const tick = (now) => {
      if (now - begin > 10000) return told([count, performance.now() - begin]);
      count += 1;
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  });
"""
LONG = """
  if (!window.long) {
    window.long = await open(archives["system.ssp"]);
    await long.restart({ structure: "SystemStructure.ssd" });
    await long.watch(["controller.tip_error_norm"]);
  }
  await long.advance(10);
  return [long.time, await long.memory()];
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
    """Processor time of a process and all that it has started, s, by what they do: `page`, `worker`, `drawing`, `other`."""
    parents, kinds = {}, {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            parents[int(entry.name)] = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            command = (entry / "cmdline").read_text()
        except OSError:
            continue
        named = {"--type=renderer": "page", "--type=gpu-process": "drawing"}
        kinds[int(entry.name)] = next((kind for flag, kind in named.items() if flag in command), "other")
    own = {root}
    while more := {pid for pid, parent in parents.items() if parent in own} - own:
        own |= more
    times = Counter()
    for pid in own & kinds.keys():
        for stat in Path(f"/proc/{pid}/task").glob("*/stat"):
            try:
                name, _, fields = stat.read_text().rpartition(")")
            except OSError:
                continue
            kind = "worker" if "DedicatedWorker" in name else kinds[pid]
            times[kind] += sum(map(int, fields.split()[11:13])) / os.sysconf("SC_CLK_TCK")
    return times


def in_page(chrome, script, count):
    """The same of `count` engines in the page."""
    before = processor_of(chrome.service.process.pid)
    factor = told(chrome, script)
    took = processor_of(chrome.service.process.pid) - before
    return count * factor, count * SECONDS / took.total()


def engine(rounds):
    """The engine compared with `cosim`."""
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
        yield row


def frames(rounds):
    """The live machine as it opens."""
    for who, *flags in rounds * [("renderer",), ("browser", "disable-gpu-compositing")]:
        chrome = chromium(*flags)
        time.sleep(2)  # The browser's own start is no part of it.
        begin = time.monotonic()
        chrome.get(PAGE.as_uri())
        run(chrome, "while (!(machine.time > 0)) await new Promise((turn) => setTimeout(turn, 5))")
        moved = time.monotonic() - begin
        run(chrome, "return machine.ready.then(() => null)")
        first = {"first motion after, s": round(moved, 2), "ready after, s": round(time.monotonic() - begin, 2)}
        # The scopes are full after their 12 s.
        run(chrome, "await machine.pause(); await machine.advance(12); machine.play()")
        root = chrome.service.process.pid
        before = processor_of(root)
        count, at = run(chrome, COUNT_FRAMES)
        took = processor_of(root) - before
        chrome.quit()
        each = {f"{kind}, ms a frame": round(1000 * took[kind] / count, 1) for kind in ("page", "drawing", "other")}
        row = {"frames a second": round(1000 * count / at, 1), **each, "worker, ms a second": round(1e6 * took["worker"] / at)}
        yield {"window by": who} | first | row


def calls(rounds):
    """A call by itself."""
    chrome = live()
    script = """const timed = async (count, seconds) => {
          const begin = performance.now();
          for (let k = 0; k < count; k += 1) await machine.advance(seconds);
          return performance.now() - begin;
        };
        await machine.restart({ trajectory: "cubic" });
        return [await timed(1, 10), await timed(200, 0.05)];"""
    for _ in range(rounds):
        one, many = run(chrome, script)
        yield {"× real time at once": round(1e4 / one, 1), "in calls of 0.05 s": round(1e4 / many, 1), "a call, ms": round((many - one) / 200, 2)}
    chrome.quit()


def live():
    """The live machine, at rest."""
    chrome = chromium("enable-precise-memory-info", "js-flags=--expose-gc")
    chrome.get(PAGE.as_uri())
    run(chrome, "await machine.ready; await machine.pause()")
    return chrome


def hour(_):
    """Memory of a long session."""
    chrome = live()
    run(chrome, "await machine.restart({ trajectory: 'rates' })")
    for second in range(0, 3600, 5):
        rate = 0.1 if second % 10 else -0.1
        run(chrome, "await machine.set('controller.rate.joint[1]', given[0]); await machine.advance(5)", rate)
        if second + 5 in (60, 600, 3600):
            script = """gc();
            const { monitor, engine } = machine;
            const traces = [...monitor.scopes.values()].flatMap(({ traces }) => traces);
            return [performance.memory.usedJSHeapSize, await engine.memory(), Math.max(...traces.map(({ indices }) => indices.length)), monitor.past.length];"""
            heap, memory, stretches, past = run(chrome, script)
            yield {"simulated, s": second + 5, "script, MB": round(heap / 1e6, 1), "engine and FMUs, bytes": memory, "stretches of a trace": stretches, "moments": past}
    chrome.quit()


def report(rounds):
    """The report as a reader opens it."""
    page = Path(os.environ["REPORT_PAGE"]).resolve()
    for _ in range(rounds):
        chrome = chromium()
        begin = time.monotonic()
        chrome.get(page.as_uri())
        loaded = chrome.execute_script("return performance.getEntriesByType('navigation')[0].loadEventEnd / 1000")
        # Plots are drawn once they come near the window.
        run(chrome, "document.querySelector('.plot').scrollIntoView(); while (!document.querySelector('.js-plotly-plot')) await new Promise((turn) => setTimeout(turn, 20))")
        yield {"MB": round(page.stat().st_size / 1e6, 2), "loaded after, s": round(loaded, 2), "first plot after, s": round(time.monotonic() - begin, 2)}
        chrome.quit()


def steps(_):
    """A long run."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        unpack(folder)
        chrome = opened(folder)
        before = processor_of(chrome.service.process.pid)
        # In pieces, since the driver waits two minutes for an answer.
        pieces = [told(chrome, LONG) for _ in range(100)]
        took = processor_of(chrome.service.process.pid) - before
        chrome.quit()
    (_, early), (end, late) = pieces[0], pieces[-1]
    yield {"simulated, s": end, "processor time, s": round(took.total(), 1), "bytes after 10^4 steps": early, "bytes at the end": late}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=5)
    measures = {measure.__name__: measure for measure in (frames, engine, calls, hour, report, steps)}
    parser.add_argument("--only", choices=measures, action="append")
    options = parser.parse_args()
    for name in options.only or [name for name in measures if name != "report" or "REPORT_PAGE" in os.environ]:
        for row in measures[name](options.rounds):
            print(json.dumps({name: row}), flush=True)


if __name__ == "__main__":
    main()
