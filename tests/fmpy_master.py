"""Co-simulation master on FMPy: instances of FMI 2.0 and 3.0, also mixed, coupled as a system structure says.

Schedules: `standard` exchanges values once a step (get all, set all, step all), which is all that FMI 2.0 promises between masters and
FMUs. The others use the staged exchange: an FMU's outputs are read again after its inputs have been set at the same communication point.
`gauss-seidel` steps the components in the order of the system and gives later ones the mean effort of the step; `jacobi` steps all from the
same values; `jacobi-derivatives` passes first time derivatives too. FMI 3.0 allows the staged exchange in Event Mode only. An output that does
not declare its dependencies is read once, right after the step, before any input of that point is set.

    python tests/fmpy_master.py --fmu-dir target/fmu --set controller.mode=3 --csv pd.csv
    python tests/fmpy_master.py --ssd target/fmu/Real.ssp --variant standard.ssd --schedule standard
"""

import argparse
import csv
import tempfile
import time
import zipfile
from itertools import groupby
from pathlib import Path

import numpy as np

from fmu import Refused, opened
from system import AS_IT_IS, AlgebraicLoop, BadSystem, System, check_parameter, described, is_read_once, levels, read_set

ROOT = Path(__file__).resolve().parent.parent
STAGED = ("gauss-seidel", "jacobi", "jacobi-derivatives")
SCHEDULES = (*STAGED, "standard")


class Transfer:
    """Values of one type read from an instance or set in it, with everything allocated."""

    def __init__(self, instance, verb, names, slots, values, transformations=()):
        self.verb, self.slots, self.values = verb, np.array(slots), values
        self.access = instance.access(verb, names)
        is_real = self.access.buffer.dtype == np.float64
        self.exchanged = self.access.buffer if is_real else np.zeros(len(names))
        self.transformations = None
        if any(t != AS_IT_IS for t in transformations):
            self.transformations = tuple(map(np.array, zip(*transformations)))

    def run(self, derivatives=False):
        call = self.access.derive if derivatives else self.access.run
        if self.verb == "Get":
            call()
            self.values[self.slots] = self.access.buffer
            return
        self.values.take(self.slots, out=self.exchanged)
        if self.transformations:
            factors, offsets = self.transformations
            self.exchanged *= factors
            self.exchanged += 0.0 if derivatives else offsets
        if self.access.buffer is not self.exchanged:
            self.access.buffer[:] = self.exchanged
        call()


class Exchange:
    """Links passed level by level: reads, then writes, one call per component and type. With all links on one level all is read, then all
    written. The outputs `once` are read before all that."""

    def __init__(self, instances, links, levels, once=()):
        sources = list(dict.fromkeys(link.source for link in links))
        self.sources, slot = sources, {source: i for i, source in enumerate(sources)}
        self.values = np.zeros(len(sources))
        self.transfers = []
        self._add(instances, "Get", [(*source, slot[source]) for source in sources if source in once])
        for level in sorted(set(levels)):
            now = [link for link, of in zip(links, levels) if of == level]
            self._add(instances, "Get", list(dict.fromkeys((*link.source, slot[link.source]) for link in now if link.source not in once)))
            self._add(instances, "Set", [(*link.target, slot[link.source], link.transformation) for link in now])

    def _add(self, instances, verb, ends):
        alike = lambda end: (end[0], instances[end[0]].fmu.accessed(end[1]))
        for (component, _), group in groupby(sorted(ends, key=lambda end: (alike(end), end)), key=alike):
            _, names, slots, *transformations = zip(*group)
            self.transfers.append(Transfer(instances[component], verb, names, slots, self.values, *transformations))

    def run(self, derivatives=False, verb=None):
        """All, or only what is read ("Get") or written ("Set")."""
        for transfer in self.transfers:
            if verb in (None, transfer.verb):
                transfer.run(derivatives)


class Master:
    """A coupled system. `settings`: {component: {variable: value}}, set before initialization."""

    def __init__(self, system, fmus, settings=None, schedule="gauss-seidel", h=1e-3, start=None):
        assert schedule in SCHEDULES
        system.check(fmus)
        start = system.start if start is None else start
        order = levels(system, fmus) if schedule in STAGED else [0] * len(system.links)
        self.system, self.schedule, self.h, self.start, self.steps = system, schedule, h, start, 0
        made = {"logging": True, "staged": schedule in STAGED}
        self.instances = {name: fmus[file].instance(name, **made) for name, file in system.components.items()}
        for name, instance in self.instances.items():
            if not instance.component:
                raise BadSystem(f"component `{name}` cannot be instantiated: {instance.text}")
            bound = {variable: parameter.value for variable, parameter in system.parameters[name].items()}
            instance.enter_initialization(start, values={**bound, **(settings or {}).get(name, {})})
        self._initialize(fmus)
        for instance in self.instances.values():
            instance.exit_initialization()
        once = {link.source for link in system.links if schedule in STAGED and is_read_once(system, fmus, link)}
        self.exchange = Exchange(self.instances, system.links, order, once)
        self.slopes = None
        if schedule == "jacobi-derivatives":
            smooth = [(link, k) for link, k in zip(system.links, order) if link.source not in once and passes_derivative(system, fmus, link)]
            self.slopes = Exchange(self.instances, *map(list, zip(*smooth)))
        self.means = self._means() if schedule == "gauss-seidel" else {}
        self.pass_all()

    def _initialize(self, fmus):
        """Pass the values in Initialization Mode: in the order of the dependencies, or where what is not declared forms a loop, until nothing
        changes, bit for bit."""
        system = self.system
        try:
            Exchange(self.instances, system.links, levels(system, fmus, initialization=True)).run()
            return
        except AlgebraicLoop:
            pass
        try:
            order = levels(system, fmus, initialization=True, declared_only=True)
        except AlgebraicLoop:
            if self.schedule in STAGED:
                raise
            order = [0] * len(system.links)
        exchange, passes = Exchange(self.instances, system.links, order), len(system.links) + 1
        for _ in range(passes):
            before = exchange.values.copy()
            exchange.run()
            if before.tobytes() == exchange.values.tobytes():
                return
        names = [".".join(source) for source, a, b in zip(exchange.sources, before, exchange.values) if a.tobytes() != b.tobytes()]
        raise BadSystem(f"in initialization {', '.join(names)} still change after {passes} passes over all connections")

    def _means(self):
        """By component: how it gets the mean efforts of the step from components stepped before it."""
        order = list(self.system.components)
        bonds = [b for b in self.system.links if b.step_mean and order.index(b.source[0]) < order.index(b.target[0])]
        values, means = np.zeros(len(bonds)), {}
        for slot, bond in enumerate(bonds):
            (source, _), (target, name) = bond.source, bond.target
            read = Transfer(self.instances[source], "Get", [bond.step_mean], [slot], values)
            means.setdefault(target, ([], [], [], []))
            for kept, new in zip(means[target], (read, name, slot, bond.transformation)):
                kept.append(new)
        return {
            target: [*reads, Transfer(self.instances[target], "Set", names, slots, values, transformations)]
            for target, (reads, names, slots, transformations) in means.items()
        }

    @property
    def time(self):
        return self.start + self.steps * self.h

    def interval(self):
        """Start and length of the next step, s."""
        return self.time, self.h

    def pass_all(self):
        """What follows a step. By `standard` outputs are only read: inputs are set just before the next step, so that whoever looks at
        outputs in between gets them before any set."""
        if self.schedule == "standard":
            self.exchange.run(verb="Get")
            return
        self.exchange.run()
        if self.slopes:
            self.slopes.run(derivatives=True)

    def step(self):
        t, h = self.interval()
        if self.schedule == "standard":
            self.exchange.run(verb="Set")
        for instance in self.instances.values():
            instance.leave_events()
        for name, instance in self.instances.items():
            for transfer in self.means.get(name, ()):
                transfer.run()
            instance.step(t, h)
        self.steps += 1
        for instance in self.instances.values():
            instance.enter_events()
        self.pass_all()

    def record(self, until, names):
        """Run to `until`; times and a row of `names` (component.variable) per communication point, the first included."""
        probes = [name.split(".", 1) for name in names]
        row = np.zeros(len(probes))
        reads = []
        alike = lambda probe: (probe[0], self.instances[probe[0]].fmu.accessed(probe[1]))
        for (component, _), group in groupby(sorted(((c, n, i) for i, (c, n) in enumerate(probes)), key=lambda p: (alike(p), p)), key=alike):
            _, some, slots = zip(*group)
            reads.append(Transfer(self.instances[component], "Get", some, slots, row))
        count = self.steps + round((until - self.time) / self.h)
        times, rows = [], []
        while True:
            for read in reads:
                read.run()
            times.append(self.time)
            rows.append(row.copy())
            if self.steps >= count:
                return np.array(times), np.array(rows)
            self.step()

    def free(self):
        for instance in self.instances.values():
            instance.free()


def passes_derivative(system, fmus, link):
    """Derivatives go where the source gives them, the target uses them and the signal is continuous."""
    (source, output), (target, _) = link.source, link.target
    of = lambda name: fmus[system.components[name]]
    return (
        of(source).variables[output].type == "Real"
        and of(source).description.coSimulation.maxOutputDerivativeOrder >= 1
        and getattr(of(target).description.coSimulation, "canInterpolateInputs", False)
        and of(source).variables[output].variability == "continuous"
    )


def addressed(system, fmus, parameters):
    """Values of a parameter set by component: its names are component.variable, or a variable that one component alone has."""
    found = {}
    for name, parameter in parameters.items():
        component, _, variable = name.partition(".")
        if component not in system.components:
            owners, variable = [c for c, file in system.components.items() if name in fmus[file].variables], name
            if len(owners) != 1:
                raise BadSystem(f"`{name}` must be a variable of one component, but {' and '.join(owners) or 'none'} has it")
            (component,) = owners
        check_parameter(f"{component}.{variable}", parameter, described(fmus[system.components[component]], variable))
        found.setdefault(component, {})[variable] = parameter.value
    return found


def setting(system, fmus, text):
    """Component, variable and value of `component.variable=value`; an enumeration by number or name of the item."""
    name, _, value = text.partition("=")
    component, _, variable = name.partition(".")
    if component not in system.components:
        raise SystemExit(f"{text}: no component `{component}`; the system has {', '.join(system.components)}")
    found = fmus[system.components[component]].variables.get(variable)
    if found is None:
        raise SystemExit(f"{text}: {component} has no variable `{variable}`")
    items = [item.name for item in found.declaredType.items] if found.type == "Enumeration" else []
    if value in items:
        return component, variable, value
    try:
        return component, variable, {"Real": float, "String": str}.get(found.type, int)(value)
    except ValueError:
        raise SystemExit(f"{text}: it must be {' or '.join(items) or 'a number'}") from None


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ssd", type=Path, default=ROOT / "system/SystemStructure.ssd", help=".ssd, or a packed .ssp")
    parser.add_argument("--variant", default="SystemStructure.ssd", help="structure to take from the .ssp, as triangular_pd.ssd")
    parser.add_argument("--fmu-dir", type=Path, help="folder of the FMUs; default: where the system says; for a .ssd else target/fmu of the repository")
    parser.add_argument("--replace", action="append", default=[], metavar="COMPONENT=FMU", help="take this FMU for a component")
    parser.add_argument("--schedule", choices=SCHEDULES, default=SCHEDULES[0])
    parser.add_argument("--step", type=float, help="communication step, s; default: the one that the system asks for, else 1e-3")
    parser.add_argument("--feedthrough", action="append", default=[], metavar="COMPONENT", help="its outputs may be read again after a set")
    parser.add_argument("--stop-time", type=float, help="s; default: the system's")
    parser.add_argument("--parameters", action="append", default=[], type=Path, metavar="SSV", help="parameter set")
    parser.add_argument("--set", action="append", default=[], metavar="COMPONENT.VARIABLE=VALUE")
    parser.add_argument("--signals", nargs="+", default=["controller.tip_error_norm"], metavar="COMPONENT.VARIABLE")
    parser.add_argument("--csv", type=Path)
    return parser.parse_args()


def fmu_files(system, ssd, fmu_dir, folder):
    """{file name: path} of the FMUs of a system; those of a package are unpacked into `folder`, if none are in `fmu_dir`."""
    if fmu_dir:
        return {name: fmu_dir / name for name in system.sources}
    if ssd.suffix != ".ssp":
        beside = {name: ssd.parent / source for name, source in system.sources.items()}
        return {name: path if path.is_file() else ROOT / "target/fmu" / name for name, path in beside.items()}
    with zipfile.ZipFile(ssd) as archive:
        for name, source in system.sources.items():
            if source not in archive.namelist():
                raise BadSystem(f"`{ssd}` does not contain `{source}`")
            (folder / name).write_bytes(archive.read(source))
    return {name: folder / name for name in system.sources}


def main():
    args = arguments()
    system = System.read(args.ssd, args.variant)
    with tempfile.TemporaryDirectory() as folder:
        paths = fmu_files(system, args.ssd, args.fmu_dir, Path(folder))
        for component, path in (text.split("=") for text in args.replace):
            system.components[component] = paths[path] = path
        if missing := [str(path) for path in paths.values() if not Path(path).is_file()]:
            raise BadSystem(f"FMU `{missing[0]}` cannot be read")
        fmus = {file: opened(paths[file], Path(folder) / str(k)) for k, file in enumerate(set(system.components.values()))}
        settings = {}
        for path in args.parameters:
            for component, values in addressed(system, fmus, read_set(path.read_bytes())).items():
                settings.setdefault(component, {}).update(values)
        for text in args.set:
            component, variable, value = setting(system, fmus, text)
            settings.setdefault(component, {})[variable] = value
        if unknown := set(args.feedthrough) - set(system.components):
            raise BadSystem(f"--feedthrough {', '.join(unknown)}: the system has no component of this name")
        system.feedthrough |= set(args.feedthrough)
        master = Master(system, fmus, settings, args.schedule, args.step or system.step or 1e-3)
        clock = time.perf_counter()
        times, rows = master.record(args.stop_time or system.stop, args.signals)
        print(f"{times[-1]:.3f} s simulated in {time.perf_counter() - clock:.1f} s")
        for name, last, largest in zip(args.signals, rows[-1], np.abs(rows).max(axis=0)):
            print(f"{name}: last {last:.6g}, largest magnitude {largest:.6g}")
        if args.csv:
            with args.csv.open("w", newline="") as file:
                writer = csv.writer(file)
                writer.writerow(["time", *args.signals])
                writer.writerows([t, *row] for t, row in zip(times, rows))
        master.free()


if __name__ == "__main__":
    try:
        main()
    except (BadSystem, Refused) as error:
        raise SystemExit(f"error: {error}") from None
