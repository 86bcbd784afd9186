"""An FMU and its instances on FMPy's FMU2Slave, by variable name; statuses and messages can be looked at."""

import itertools
from ctypes import CFUNCTYPE, POINTER, byref, c_char_p, c_double, c_int, c_uint, c_void_p, cast, string_at
from typing import NamedTuple

import fmpy
import numpy as np
from fmpy import fmi2

OK, WARNING, DISCARD, ERROR, FATAL = range(5)

# The message is a format without arguments, so the variadic function can be received as one of five parameters (on Linux, Windows and
# macOS on x86-64, Linux on arm64).
LOGGER = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)

_names = itertools.count(1)


class Refused(Exception):
    """A call that did not return fmi2OK or fmi3OK, with status and text."""

    def __init__(self, function, status, text):
        super().__init__(f"{function} returned {status}: {text}")
        self.status, self.text = status, text


class Unknown(NamedTuple):
    """A computed variable with those that it depends on; None: on all inputs."""

    variable: object
    dependencies: list | None


def opened(path, folder):
    """An FMU of FMI 2.0 or 3.0."""
    from by_element import Fmu3

    is_3 = fmpy.read_model_description(str(path), validate=False).fmiVersion.startswith("3.")
    return (Fmu3 if is_3 else Fmu)(path, folder)


class Unpacked:
    """An unpacked FMU of any version: its files and variables."""

    def __init__(self, path, folder):
        self.path = str(path)
        self.folder = str(fmpy.extract(self.path, unzipdir=str(folder)))
        self.description = fmpy.read_model_description(self.folder, validate=False)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.identifier = self.description.coSimulation.modelIdentifier

    def names(self, causality):
        return [name for name, variable in self.variables.items() if variable.causality == causality]

    def new_name(self):
        """A name for an instance that no other has."""
        return f"{self.identifier.lower()}_{next(_names)}"


class Called:
    """An instance of any version: its messages, of which the text is the last part, and calls that must succeed."""

    @property
    def text(self):
        """The last message."""
        return self.messages[-1][-1] if self.messages else ""

    def call(self, function, *arguments):
        status = self.status(function, *arguments)
        if status != OK:
            raise Refused(function, status, self.text)


class Fmu(Unpacked):
    """An unpacked FMU of FMI 2.0."""

    def __init__(self, path, folder):
        super().__init__(path, folder)
        self.index = {name: i for i, name in enumerate(self.variables)}

    def unknowns(self, initialization):
        """Outputs, or what is computed in initialization."""
        listed = self.description.initialUnknowns if initialization else self.description.outputs
        return [Unknown(u.variable, u.dependencies) for u in listed]

    def accessed(self, name):
        """The type by whose functions a variable is read and set."""
        kind = self.variables[name].type
        return "Integer" if kind == "Enumeration" else kind

    def instance(self, name=None, **options):
        return Instance(self, name or self.new_name(), **options)

    def running(self, start=0.0, **values):
        """An instance in Step Complete; `values` go by name, dots and brackets with `set`."""
        return self.instance().start(start, values)


class Instance(Called):
    """One instance. Every method but `status` raises `Refused` if the FMU does not return fmi2OK."""

    def __init__(self, fmu, name, guid=None, resources="", logging=False, callbacks=True, staged=False):
        """`staged` has no effect: in FMI 2.0 an FMU allows a get after a set, or it does not."""
        self.fmu, self.name, self.messages = fmu, name, []
        self.slave = fmi2.FMU2Slave(
            guid=fmu.description.guid, modelIdentifier=fmu.identifier, unzipDirectory=fmu.folder, instanceName=name
        )
        self._logger = LOGGER(self._log)
        self.callbacks = fmi2.fmi2CallbackFunctions()
        if callbacks:
            self.callbacks.logger = cast(self._logger, fmi2.fmi2CallbackLoggerTYPE)
            self.callbacks.allocateMemory = fmi2.defaultCallbacks.allocateMemory
            self.callbacks.freeMemory = fmi2.defaultCallbacks.freeMemory
        if resources == "":
            resources = f"file://{fmu.folder}/resources"
        self.component = self.slave.dll.fmi2Instantiate(
            name.encode(),
            fmi2.fmi2CoSimulation,
            (fmu.description.guid if guid is None else guid).encode(),
            None if resources is None else resources.encode(),
            byref(self.callbacks),
            0,
            int(logging),
        )
        self.slave.component = self.component

    def _log(self, _environment, name, status, category, form):
        text = form.decode().replace("%%", "%").replace("##", "#")
        self.messages.append((name.decode(), status, category.decode(), form.decode(), text))

    def status(self, function, *arguments):
        """Call a C function with this instance as first argument; the status it returns."""
        return getattr(self.slave.dll, function)(self.component, *arguments)

    def references(self, names):
        return (c_uint * len(names))(*(self.fmu.variables[n].valueReference for n in names))

    def set(self, values):
        """Set by name, one call a type; an enumeration by number or by the name of its item."""
        for kind, ctype, names in _by_type(self.fmu, values):
            data = (ctype * len(names))(*(_coded(self.fmu.variables[n], values[n]) for n in names))
            self.call(f"fmi2Set{kind}", self.references(names), len(names), data)

    def get(self, *names):
        """Values by name, as a list; one name: its value."""
        found = {}
        for kind, ctype, some in _by_type(self.fmu, names):
            data = (ctype * len(some))()
            self.call(f"fmi2Get{kind}", self.references(some), len(some), data)
            found.update(zip(some, data))
        values = [v.decode() if isinstance(v := found[n], bytes) else v for n in names]
        return values[0] if len(values) == 1 else values

    def outputs(self):
        """All outputs by name."""
        names = self.fmu.names("output")
        return dict(zip(names, self.get(*names)))

    def start(self, start=0.0, values=None, stop=None):
        """Set `values`, then to Step Complete."""
        if values:
            self.set(values)
        self.enter_initialization(start, stop)
        self.exit_initialization()
        return self

    def enter_initialization(self, start=0.0, stop=None, values=None, tolerance=None):
        """`values` are set after fmi2SetupExperiment, in which FMUs of 20-sim forget what was set before."""
        self.setup(start, stop, tolerance)
        if values:
            self.set(values)
        self.call("fmi2EnterInitializationMode")

    def exit_initialization(self):
        self.call("fmi2ExitInitializationMode")

    def enter_events(self):
        """There is no Event Mode in co-simulation."""

    def leave_events(self):
        """As above."""

    def access(self, verb, names):
        """How variables of one type are read or set together."""
        return Access(self, verb, names)

    def setup(self, start=0.0, stop=None, tolerance=None):
        self.call("fmi2SetupExperiment", int(tolerance is not None), tolerance or 0.0, start, int(stop is not None), stop or 0.0)

    def step(self, t, h):
        self.call("fmi2DoStep", t, h, 1)

    def set_derivatives(self, values, order=1):
        names = list(values)
        data = (c_double * len(names))(*values.values())
        orders = (c_int * len(names))(*[order] * len(names))
        self.call("fmi2SetRealInputDerivatives", self.references(names), len(names), orders, data)

    def derivatives(self, *names):
        """First time derivatives of outputs."""
        data, orders = (c_double * len(names))(), (c_int * len(names))(*[1] * len(names))
        self.call("fmi2GetRealOutputDerivatives", self.references(names), len(names), orders, data)
        return list(data)

    def directional(self, unknowns, seed):
        """Directional derivative of `unknowns` along `seed`, a value per known input."""
        knowns = list(seed)
        direction, result = (c_double * len(knowns))(*seed.values()), (c_double * len(unknowns))()
        unknown, known = self.references(unknowns), self.references(knowns)
        self.call("fmi2GetDirectionalDerivative", unknown, len(unknowns), known, len(knowns), direction, result)
        return list(result)

    def save(self):
        return self.slave.getFMUstate()

    def restore(self, state):
        self.slave.setFMUstate(state)

    def serialize(self):
        """Bytes of the present state."""
        state = self.save()
        data = self.slave.serializeFMUstate(state)
        self.slave.freeFMUstate(state)
        return data

    def deserialize(self, data):
        state = self.slave.deSerializeFMUstate(data)
        self.slave.setFMUstate(state)
        self.slave.freeFMUstate(state)

    def free(self):
        self.slave.dll.fmi2FreeInstance(self.component)
        self.component = self.slave.component = None


class Access:
    """One fmi2Get… or fmi2Set… of Real, Integer or Boolean (or of derivatives), with everything allocated."""

    def __init__(self, instance, verb, names):
        self.kind = instance.fmu.accessed(names[0])
        self.instance, self.verb = instance, verb
        self.n, self.references = len(names), instance.references(names)
        ctype = TYPES[self.kind]
        self.buffer = np.zeros(self.n, dtype=np.dtype(ctype))
        self.pointer, self.orders = self.buffer.ctypes.data_as(POINTER(ctype)), (c_int * self.n)(*[1] * self.n)

    def run(self):
        self.instance.call(f"fmi2{self.verb}{self.kind}", self.references, self.n, self.pointer)

    def derive(self):
        """First time derivatives of outputs or inputs."""
        function = {"Get": "fmi2GetRealOutputDerivatives", "Set": "fmi2SetRealInputDerivatives"}[self.verb]
        self.instance.call(function, self.references, self.n, self.orders, self.pointer)


TYPES = {"Real": c_double, "Integer": c_int, "Boolean": c_int, "String": c_char_p}


def _by_type(fmu, names):
    """(FMI type, C type, names) for each type among the names; enumerations are integers."""
    kinds = {}
    for name in names:
        kind = fmu.variables[name].type
        kinds.setdefault("Integer" if kind == "Enumeration" else kind, []).append(name)
    return [(kind, TYPES[kind], some) for kind, some in kinds.items()]


def _coded(variable, value):
    if variable.type == "Enumeration" and isinstance(value, str):
        return {item.name: int(item.value) for item in variable.declaredType.items}[value]
    return value.encode() if isinstance(value, str) else value
