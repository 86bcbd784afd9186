"""Error over component steps of the quarter car and of an oscillator of two masses: steps of one length, by energy, by doubling; inputs of power
bonds held or balanced.

    python tests/bench/steps.py target/fmu-examples [--program target/release/cosim] [--csv out.csv]

The folder holds Chassis.fmu and Wheel.fmu. `--machine target/fmu` adds the machine of Manipulator.ssp there, whose error is the root mean square
distance of its tip from a run at 10 us. The error is the root mean square over time of what body and wheel are off the exact solution
(closed form; of the damper of exponent 0.5 SciPy's DOP853), relative to the root mean square of the exact ones.
"""

import argparse
import csv
import subprocess
import sys
import tempfile
import zipfile
from itertools import product
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

STRUCTURE = Path(__file__).parents[2] / "examples" / "quarter-car" / "SystemStructure.ssd"


class Case:
    """A quarter car: parameters besides the defaults of the FMUs."""

    def __init__(self, stop, **values):
        p = dict(m_body=400.0, k=15e3, d=1e3, exponent=1.0, m=40.0, k_tyre=150e3, height=0.1, time=0.0, period=0.0, s_start=0.0, x_start=0.0, load=0.0)
        p.update(values)
        self.p, self.stop = p, stop
        count = 1 if p["period"] == 0 else int((stop - p["time"]) / p["period"]) + 1
        self.edges = [p["time"] + k * p["period"] for k in range(count)]

    def settings(self):
        names = dict(load="chassis.F_0", m_body="chassis.m", k="chassis.k", d="chassis.d", exponent="chassis.exponent", s_start="chassis.s_start", m="wheel.m",
                     k_tyre="wheel.k", height="wheel.road.height", time="wheel.road.time", period="wheel.road.period", x_start="wheel.x_start")
        load = f"--set=wheel.F_0={self.p['load']!r}"
        return [load, *(f"--set={names[name]}={value!r}" for name, value in self.p.items())]

    def rate(self, y, road):
        """Of body, its velocity, compression, wheel, its velocity; the load at rest does no work around rest."""
        p = self.p
        s_dot = y[4] - y[1]
        force = -p["k"] * y[2] - p["d"] * np.copysign(abs(s_dot) ** p["exponent"], s_dot)
        return np.array([y[1], -force / p["m_body"], s_dot, y[4], (force - p["k_tyre"] * (y[3] - road)) / p["m"]])

    def exact(self, times):
        """States at these times, a column for each."""
        bounds = [0.0] + [t for t in self.edges if 0 < t < self.stop] + [self.stop]
        y, out = np.array([0.0, 0.0, self.p["s_start"], self.p["x_start"], 0.0]), np.empty((5, len(times)))
        for begin, end in zip(bounds, bounds[1:]):
            road = self.p["height"] * (sum(t <= begin for t in self.edges) % 2)
            # Rounding of sums of steps at the bounds does not matter: what is a bit early there is continued.
            own = (times >= begin) & (times <= end if end == self.stop else times < end)
            if self.p["exponent"] == 1.0:
                # Motion about rest, where the suspension and the tyre carry nothing, by eigenvectors.
                x, v, s, wheel, v_wheel = y
                offset = wheel - s - x
                rest = np.array([road - offset, 0.0, road, 0.0])
                full = lambda z: np.array([z[0], z[1], z[2] - z[0], z[2], z[3]])
                a = np.column_stack([self.rate(full(e), 0.0)[[0, 1, 3, 4]] for e in np.eye(4)])
                values, vectors = np.linalg.eig(a)
                weights = np.linalg.solve(vectors, np.array([x, v, wheel, v_wheel]) - rest)
                motion = lambda t: rest[:, None] + (vectors @ (weights[:, None] * np.exp(np.outer(values, t - begin)))).real
                state = lambda t: np.vstack([(z := motion(t))[0], z[1], z[2] - z[0] - offset, z[2], z[3]])
                out[:, own], y = state(times[own]), state(np.array([end]))[:, 0]
            else:
                run = solve_ivp(lambda _t, y: self.rate(y, road), (begin, end), y, method="DOP853", rtol=1e-9, atol=1e-11, dense_output=True)
                out[:, own], y = run.sol(times[own]), run.y[:, -1]
        return out


def packed(fmus, folder):
    path = Path(folder) / "QuarterCar.ssp"
    with zipfile.ZipFile(path, "w") as ssp:
        ssp.write(STRUCTURE, "SystemStructure.ssd")
        for name in ("Chassis.fmu", "Wheel.fmu"):
            ssp.write(Path(fmus) / name, f"resources/{name}")
    return path


def run(program, ssp, case, options):
    """Component steps, error, rows of the run."""
    out = ssp.with_name("run.csv")
    command = [program, "run", "--quiet", "--system", ssp, "--stop-time", str(case.stop), "--csv", out, "--signals", "chassis.x_body,wheel.x"]
    text = subprocess.run([*map(str, command), *case.settings(), *options], check=True, capture_output=True, text=True).stdout
    with open(out) as file:
        rows = list(csv.DictReader(file))
    column = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
    count = next((line.split(", ")[1].split()[0] for line in text.splitlines() if " computed" in line), len(rows) - 1)
    return 2 * int(count), error(case, column), column


def error(case, column):
    t = column["time"]
    exact = case.exact(t)
    mean = lambda values: np.trapezoid(values, t) / (t[-1] - t[0])
    pairs = [(column["chassis.x_body"], exact[0]), (column["wheel.x"], exact[3])]
    return np.sqrt(np.mean([mean((x - y) ** 2) / mean(y**2) for x, y in pairs]))


WEIGHT = 400 * 9.81
CASES = {
    "quarter car, linear": Case(8.0),
    "quarter car, damper of exponent 0.5": Case(8.0, exponent=0.5),
    "quarter car, road up and down every 4 s": Case(16.0, time=0.5, period=4.0, load=WEIGHT),
    "oscillator of two masses": Case(4.0, d=0.0, height=0.0, s_start=0.1),
}
METHODS = {
    "fixed": [["--step", str(h)] for h in (1e-5, 2e-4, 5e-4, 1e-3, 2e-3, 4e-3)],
    "energy": [["--energy-tolerance", str(tolerance)] for tolerance in (1e-6, 1e-5, 1e-4, 1e-3, 1e-2)],
    "energy, repeated": [["--energy-tolerance", str(tolerance), "--repeat-steps"] for tolerance in (1e-6, 1e-5, 1e-4, 1e-3, 1e-2)],
    "doubling": [["--doubling-tolerance", str(tolerance)] for tolerance in (1e-5, 1e-4, 1e-3, 1e-2)],
}


MACHINE = {
    # The tip goes 100 mm down in 0.8 s: onto a soft plane 93 mm below it, or with 200 kg more half-way.
    "machine, contact": (["hdrm.contact.stiffness=2e4", "hdrm.contact.offset=2.995"], None),
    "machine, load picked up": ([], "time,hdrm.load.mass\n0,0\n0.6,200\n"),
}


def machine_run(program, ssp, folder, case, options):
    """Component steps, times, positions of the tip (mm), a row for each."""
    settings, table = MACHINE[case]
    out, given = Path(folder) / "machine.csv", Path(folder) / "input.csv"
    command = [program, "run", "--quiet", "--system", ssp, "--stop-time", "1.4", "--csv", out, "--signals", "hdrm.tip.position*", *options]
    command += [f"--set={text}" for text in ["controller.trajectory=cubic", "controller.settle_time=0.2", *settings]]
    if table:
        given.write_text(table)
        command += ["--input", given]
    text = subprocess.run([*map(str, command)], check=True, capture_output=True, text=True).stdout
    rows = np.genfromtxt(out, delimiter=",", names=True)
    count = next((line.split(", ")[1].split()[0] for line in text.splitlines() if " computed" in line), len(rows) - 1)
    tip = np.column_stack([rows[name] for name in rows.dtype.names if name.startswith("hdrmtipposition")])
    return 5 * int(count), rows["time"], 1e3 * tip


def machine(program, fmus, folder):
    """Rows of the table for the machine."""
    ssp = Path(fmus) / "Manipulator.ssp"
    for case in MACHINE:
        _, exact_times, exact = machine_run(program, ssp, folder, case, ["--step", "1e-5"])
        methods = [(method, options) for method, all_options in METHODS.items() for options in all_options[1:]]
        chosen = [("with", method, [*options, "--between", between]) for method, options in methods for between in ("held", "balanced")]
        # Without mean efforts, and with derivatives in their place, which these FMUs have.
        fixed = METHODS["fixed"][1:]
        others = {"without": ["--schedule", "jacobi"], "derivatives": ["--schedule", "jacobi", "--input-derivatives"]}
        chosen += [(means, "fixed", [*options, *more]) for means, more in others.items() for options in fixed]
        for means, method, options in chosen:
            try:
                steps, times, tip = machine_run(program, ssp, folder, case, options)
            except subprocess.CalledProcessError as error:
                if error.returncode == 2:
                    raise RuntimeError(error.stderr) from error
                # The run ends where it diverges.
                yield [case, means, method, " ".join(options), 0, np.inf]
                continue
            beside = np.column_stack([np.interp(times, exact_times, column) for column in exact.T])
            wrong = np.sqrt(np.trapezoid(((tip - beside) ** 2).sum(axis=1), times) / times[-1])
            yield [case, means, method, " ".join(options), steps, wrong]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("fmus")
    parser.add_argument("--program", default="target/release/cosim")
    parser.add_argument("--csv")
    parser.add_argument("--machine", help="folder with Manipulator.ssp")
    parser.add_argument("--case", help="only cases whose name has this")
    arguments = parser.parse_args()
    table = []
    with tempfile.TemporaryDirectory() as folder:
        ssp = packed(arguments.fmus, folder)
        for name, case in CASES.items():
            if arguments.case and arguments.case not in name:
                continue
            for (schedule, means), between in product((("gauss-seidel", "with"), ("jacobi", "without")), ("held", "balanced")):
                for method, all_options in METHODS.items():
                    for options in all_options:
                        options = [*options, "--between", between]
                        steps, wrong, _ = run(arguments.program, ssp, case, ["--schedule", schedule, *options])
                        table.append([name, means, method, " ".join(options), steps, wrong])
                        print(f"{name:40} {means:8} mean efforts  {' '.join(options):64} {steps:9} component steps  error {wrong:.2e}", flush=True)
        for row in machine(arguments.program, arguments.machine, folder) if arguments.machine else []:
            table.append(row)
            print(f"{row[0]:40} {row[3]:64} {row[4]:9} component steps  error {row[5]:.2e} mm", flush=True)
    if arguments.csv:
        with open(arguments.csv, "w", newline="") as file:
            csv.writer(file).writerows([["case", "mean efforts", "method", "options", "component steps", "error"], *table])


if __name__ == "__main__":
    sys.exit(main())
