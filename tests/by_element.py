"""An FMU of FMI 3.0 and its instances on FMPy's FMU3Slave, seen as one of FMI 2.0: each element of an array by its name, `zeta[3]`."""

from ctypes import POINTER, byref, c_bool, c_char_p, c_double, c_float, c_int, c_int8, c_int16, c_int32, c_int64, c_size_t
from ctypes import c_uint, c_uint8, c_uint16, c_uint32, c_uint64, c_void_p
from dataclasses import dataclass
from itertools import product

import numpy as np
from fmpy import fmi3

from fmu import OK, Instance, Refused, Unknown, Unpacked
from system import BadSystem

#: C types by FMI type.
TYPES = {"Float64": c_double, "Float32": c_float, "Boolean": c_bool, "String": c_char_p, "Int8": c_int8, "UInt8": c_uint8, "Int16": c_int16}
TYPES |= {"UInt16": c_uint16, "Int32": c_int32, "UInt32": c_uint32, "Int64": c_int64, "UInt64": c_uint64}

#: Types of FMI 2.0 by those of FMI 3.0; others stay what they are.
AS_IN_2 = {name: "Integer" for name in TYPES} | {"Float64": "Real", "Float32": "Real", "Boolean": "Boolean", "String": "String", "Enumeration": "Enumeration"}


@dataclass
class Element:
    """A scalar variable, or an element of an array, with the attributes that FMPy's variables have."""

    name: str
    array: object
    place: int

    @property
    def type(self):
        return AS_IN_2.get(self.array.type, self.array.type)

    def __getattr__(self, name):
        return getattr(self.array, name)


def elements(variable):
    """The elements of a variable, the last index running fastest."""
    if not variable.shape:
        return [Element(variable.name, variable, 0)]
    indices = product(*(range(1, length + 1) for length in variable.shape))
    return [Element(f"{variable.name}[{','.join(map(str, index))}]", variable, k) for k, index in enumerate(indices)]


class Fmu3(Unpacked):
    """An unpacked FMU of FMI 3.0."""

    def __init__(self, path, folder):
        super().__init__(path, folder)
        self.by_array = {v.name: elements(v) for v in self.description.modelVariables}
        self.variables = {e.name: e for some in self.by_array.values() for e in some}

    def unknowns(self, initialization):
        """Outputs, or what is computed in initialization, by element; an array depends on whole arrays."""
        by_element = lambda variable: self.by_array[variable.name]
        listed = self.description.initialUnknowns if initialization else self.description.outputs
        for unknown in listed:
            known = unknown.dependencies
            known = None if known is None else [e for v in known for e in by_element(v)]
            yield from (Unknown(e, known) for e in by_element(unknown.variable))

    def accessed(self, name):
        """The type by whose functions a variable is read and set."""
        kind = self.variables[name].array.type
        return "Int64" if kind == "Enumeration" else kind

    def instance(self, name=None, **options):
        return Instance3(self, name or self.new_name(), **options)

    def running(self, start=0.0, **values):
        """An instance in Step Mode; `values` go by name, dots and brackets with `set`."""
        return self.instance().start(start, values)


class Instance3(Instance):
    """One instance. With `staged` it is in Event Mode at communication points, where alone FMI 3.0 allows a get after a set."""

    def __init__(self, fmu, name, logging=False, staged=False):
        if staged and not fmu.description.coSimulation.hasEventMode:
            raise BadSystem(
                f"{name}: FMU `{fmu.path}` is of FMI 3.0 and has no Event Mode, outside of which no output may be read after an input was set: "
                "it runs with the schedule `standard` only"
            )
        self.fmu, self.name, self.messages, self.staged = fmu, name, [], staged
        self.slave = fmi3.FMU3Slave(
            guid=fmu.description.guid, modelIdentifier=fmu.identifier, unzipDirectory=fmu.folder, instanceName=name
        )
        self._logger = fmi3.fmi3LogMessageCallback(self._log)
        token, resources = fmu.description.guid.encode(), f"{fmu.folder}/resources/".encode()
        arguments = name.encode(), token, resources, False, logging, staged, False, None, 0, None, self._logger, fmi3.fmi3IntermediateUpdateCallback()
        self.component = self.slave.fmi3InstantiateCoSimulation(*arguments)
        self.slave.component = self.component
        self.given = {}  # what was last given to the elements of arrays of which not all are set
        self.time = float("nan")

    def _log(self, _environment, status, category, message):
        text = message.decode()
        self.messages.append((self.name, status, category.decode(), text, text))

    def status(self, function, *arguments):
        found = getattr(self.slave.dll, function)
        found.restype = c_int
        return found(c_void_p(self.component), *arguments)

    def access(self, verb, names):
        """How elements of one type are read or set together: see `Access3`."""
        return Access3(self, verb, names)

    def set(self, values):
        kinds = {}
        for name in values:
            kinds.setdefault(self.fmu.variables[name].array.type, []).append(name)
        for kind, names in kinds.items():
            if kind == "String":
                self._set_strings({name: values[name] for name in names})
            else:
                access = Access3(self, "Set", names)
                access.buffer[:] = [coded(self.fmu.variables[n], values[n]) for n in names]
                access.run()

    def _set_strings(self, values):
        for name, value in values.items():
            element = self.fmu.variables[name]
            if element.shape:
                raise NotImplementedError(f"{name}: arrays of strings")
            vr, data = (c_uint * 1)(element.valueReference), (c_char_p * 1)(value.encode())
            self.call("fmi3SetString", vr, c_size_t(1), data, c_size_t(1))

    def get(self, *names):
        found = {}
        for name in names:
            access = Access3(self, "Get", [name])
            access.run()
            found[name] = access.buffer[0].item()
        values = [found[n] for n in names]
        return values[0] if len(values) == 1 else values

    def enter_initialization(self, start=0.0, stop=None, values=None, tolerance=None):
        self.time = start
        if values:
            self.set(values)
        told = [word for value in (tolerance, stop) for word in (c_bool(value is not None), c_double(value or 0.0))]
        self.call("fmi3EnterInitializationMode", *told[:2], c_double(start), *told[2:])

    def exit_initialization(self):
        self.call("fmi3ExitInitializationMode")

    def step(self, t, h):
        event, ends, early, last = c_bool(), c_bool(), c_bool(), c_double()
        results = byref(event), byref(ends), byref(early), byref(last)
        self.call("fmi3DoStep", c_double(t), c_double(h), c_bool(True), *results)
        if ends or early:
            raise Refused("fmi3DoStep", OK, f"it ended at {last.value} s")
        self.time = last.value

    def enter_events(self):
        if self.staged:
            self.call("fmi3EnterEventMode")

    def leave_events(self):
        """Back to Step Mode. The FMUs of these tests have no discrete states that change in Event Mode."""
        if not self.staged:
            return
        flags, time = [c_bool() for _ in range(5)], c_double()
        self.call("fmi3UpdateDiscreteStates", *map(byref, flags), byref(time))
        if flags[0] or flags[1]:
            raise Refused("fmi3UpdateDiscreteStates", OK, "discrete states changed, or the simulation is to end")
        self.call("fmi3EnterStepMode")

    def free(self):
        self.slave.dll.fmi3FreeInstance.restype = None
        self.slave.dll.fmi3FreeInstance(c_void_p(self.component))
        self.component = self.slave.component = None


class Access3:
    """Elements of one type read or set by one call, everything allocated. FMI 3.0 passes whole arrays: to set some elements, the others are
    given as they were last."""

    def __init__(self, instance, verb, names):
        variables = [instance.fmu.variables[name] for name in names]
        kind = instance.fmu.accessed(names[0])
        self.instance, self.verb, self.function = instance, verb, f"fmi3{verb}{kind}"
        arrays = list({v.valueReference: v for v in variables}.values())
        self.references = (c_uint * len(arrays))(*(v.valueReference for v in arrays))
        sizes = [len(instance.fmu.by_array[v.array.name]) for v in arrays]
        firsts = dict(zip(self.references, np.cumsum([0, *sizes[:-1]])))
        self.places = np.array([firsts[v.valueReference] + v.place for v in variables])
        self.dtype = np.dtype(TYPES[kind])
        self.buffer, self.passed = np.zeros(len(names), self.dtype), np.zeros(sum(sizes), self.dtype)
        self.memories = [(instance.given.setdefault(v.valueReference, self.start(v, n)), n) for v, n in zip(arrays, sizes)]
        self.pointer = self.passed.ctypes.data_as(POINTER(TYPES[kind]))
        self.n, self.m = c_size_t(len(arrays)), c_size_t(len(self.passed))
        self.orders = (c_int * len(arrays))(*[1] * len(arrays))

    def start(self, variable, size):
        """Start values of all elements; an output has none."""
        if variable.start is None:
            return np.zeros(size, self.dtype)
        words = str(variable.start).split()
        values = [word == "true" if word in ("true", "false") else float(word) for word in words]
        return np.array(values if len(values) == size else values * size, self.dtype)

    def run(self):
        if self.verb == "Set":
            first = 0
            for memory, n in self.memories:
                self.passed[first : first + n] = memory
                first += n
            self.passed[self.places] = self.buffer
            first = 0
            for memory, n in self.memories:
                memory[:] = self.passed[first : first + n]
                first += n
        self.instance.call(self.function, self.references, self.n, self.pointer, self.m)
        if self.verb == "Get":
            self.passed.take(self.places, out=self.buffer)

    def derive(self):
        """First time derivatives of outputs; FMI 3.0 has none of inputs."""
        assert self.verb == "Get"
        self.instance.call("fmi3GetOutputDerivatives", self.references, self.n, self.orders, self.pointer, self.m)
        self.passed.take(self.places, out=self.buffer)


def coded(element, value):
    if element.array.type == "Enumeration" and isinstance(value, str):
        return {item.name: int(item.value) for item in element.declaredType.items}[value]
    return value
