"""An FMU of FMI 3.0 and its instances, through the C functions of its library; statuses and messages can be looked at."""

from ctypes import CDLL, CFUNCTYPE, byref, c_bool, c_char_p, c_double, c_int, c_int32, c_int64, c_size_t, c_uint32, c_uint8, c_void_p
from pathlib import Path

from fmu import Called, Unpacked

LOGGER = CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)
TYPES = {"Float64": c_double, "Int32": c_int32, "Int64": c_int64, "Boolean": c_bool, "String": c_char_p}


class Fmu3(Unpacked):
    """An unpacked FMU."""

    def __init__(self, path, folder):
        super().__init__(path, folder)
        self.folder = Path(self.folder)
        self.library = self.folder / f"binaries/x86_64-linux/{self.identifier}.so"

    def length(self, name):
        """Number of elements of a variable."""
        dimensions = self.variables[name].dimensions
        return int(dimensions[0].start) if dimensions else 1

    def access(self, name):
        """Type by which a variable is set and read."""
        kind = self.variables[name].type
        return "Int64" if kind == "Enumeration" else kind

    def elements(self, name):
        """Names of the elements, as FMI 2.0 has them."""
        if not self.variables[name].dimensions:
            return [name]
        stem, end = (name[:-1], ")") if name.startswith("der(") else (name, "")
        return [f"{stem}[{i + 1}]{end}" for i in range(self.length(name))]

    def instance(self, **options):
        return Instance3(self, self.new_name(), **options)


class Instance3(Called):
    """One instance. Every method but `status` raises `Refused` if the FMU does not return fmi3OK."""

    def __init__(self, fmu, name, logging=True, event_mode=False, early_return=False):
        self.fmu, self.messages = fmu, []
        self.library = CDLL(str(fmu.library))
        self._logger = LOGGER(lambda _env, status, category, text: self.messages.append((status, category.decode(), text.decode())))
        self.event_mode = event_mode
        instantiate = self.library.fmi3InstantiateCoSimulation
        instantiate.restype = c_void_p
        self.c = c_void_p(
            instantiate(
                name.encode(),
                fmu.description.guid.encode(),
                f"{fmu.folder}/resources/".encode(),
                c_bool(False),
                c_bool(logging),
                c_bool(event_mode),
                c_bool(early_return),
                None,
                c_size_t(0),
                None,
                self._logger,
                None,
            )
        )
        assert self.c.value, self.messages

    def status(self, function, *arguments):
        return getattr(self.library, function)(self.c, *arguments)

    def references(self, names):
        return (c_uint32 * len(names))(*(self.fmu.variables[n].valueReference for n in names))

    def set(self, name, *values):
        kind = self.fmu.access(name)
        data = (TYPES[kind] * len(values))(*(v.encode() if isinstance(v, str) else v for v in values))
        self.call(f"fmi3Set{kind}", self.references([name]), c_size_t(1), data, c_size_t(len(values)))

    def get(self, name):
        """All elements of a variable."""
        kind, n = self.fmu.access(name), self.fmu.length(name)
        data = (TYPES[kind] * n)()
        self.call(f"fmi3Get{kind}", self.references([name]), c_size_t(1), data, c_size_t(n))
        return list(data)

    def outputs(self):
        """All outputs by element."""
        found = {}
        for name in self.fmu.names("output"):
            found.update(zip(self.fmu.elements(name), self.get(name)))
        return found

    def initialize(self, start=0.0):
        self.call("fmi3EnterInitializationMode", c_bool(False), c_double(0), c_double(start), c_bool(False), c_double(0))
        self.call("fmi3ExitInitializationMode")
        return self

    def update(self):
        flags, time = [c_bool(True) for _ in range(5)], c_double()
        self.call("fmi3UpdateDiscreteStates", *map(byref, flags), byref(time))
        assert not any(flag.value for flag in flags)

    def step(self, t, h):
        flags, time = [c_bool(True) for _ in range(3)], c_double()
        self.call("fmi3DoStep", c_double(t), c_double(h), c_bool(True), *map(byref, flags), byref(time))
        assert not any(flag.value for flag in flags) and time.value == t + h

    def save(self):
        state = c_void_p()
        self.call("fmi3GetFMUState", byref(state))
        return state

    def serialize(self):
        """Bytes of the present state."""
        state, size = self.save(), c_size_t()
        self.call("fmi3SerializedFMUStateSize", state, byref(size))
        data = (c_uint8 * size.value)()
        self.call("fmi3SerializeFMUState", state, data, size)
        self.call("fmi3FreeFMUState", byref(state))
        return bytes(data)

    def free(self):
        free = self.library.fmi3FreeInstance
        free.restype = None
        free(self.c)
