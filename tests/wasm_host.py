"""An FMU's WebAssembly in wasmtime: its component, and the plain module inside, driven as `fmu3.Instance3` drives a library."""

import ctypes
import zipfile
from ctypes import c_bool, c_char_p, c_double, c_size_t, c_void_p

import wasmtime
from wasmtime import component as components

from fmu import DISCARD, ERROR, FATAL, OK, WARNING, Called, Refused
from fmu3 import TYPES, Fmu3, Instance3

STATUSES = {"ok": OK, "warning": WARNING, "discard": DISCARD, "error": ERROR, "fatal": FATAL}
ENGINE = wasmtime.Engine()
SCRATCH = 1 << 16  # bytes for the arguments of a call


class Lost(Exception):
    """The call trapped: the instance of WebAssembly is of no use any more."""


def module_of(component):
    """The plain module in a component: its first section with the id 1."""
    at = 8
    while at < len(component):
        kind, at, size, shift = component[at], at + 1, 0, 0
        while True:
            size |= (component[at] & 0x7F) << shift
            shift, at = shift + 7, at + 1
            if component[at - 1] < 0x80:
                break
        if kind == 1:
            return component[at : at + size]
        at += size
    raise ValueError("there is no module in this component")


class FmuWasm(Fmu3):
    """An unpacked FMU of FMI 3.0 with WebAssembly, which is compiled once for all instances."""

    def __init__(self, path, folder):
        super().__init__(path, folder)
        self.bytes = zipfile.ZipFile(path).read(f"binaries/wasm32-wasip2/{self.identifier}.wasm")
        self._compiled = {}

    def compiled(self, kind):
        if kind not in self._compiled:
            plain = kind is Plain
            self._compiled[kind] = wasmtime.Module(ENGINE, module_of(self.bytes)) if plain else components.Component(ENGINE, self.bytes)
        return self._compiled[kind]


class Plain(Instance3):
    """An instance of the plain module, by the C functions: arguments are ctypes as for a library, and are copied into its memory."""

    def __init__(self, fmu, name=None, logging=True, event_mode=False, token=None, required=()):
        self.fmu, self.messages, self.updates = fmu, [], []
        self.store = wasmtime.Store(ENGINE)
        module = fmu.compiled(Plain)
        imports = {"log-message": self._told, "intermediate-update": self._updated, **{f"[resource-new]{kind}-instance": lambda this: this for kind in ("co-simulation", "model-exchange")}}
        functions = [wasmtime.Func(self.store, i.type, imports[i.name]) for i in module.imports]
        self.exports = wasmtime.Instance(self.store, module, functions).exports(self.store)
        self.memory = self.exports["memory"]
        self.functions = {}
        self.scratch, self.used = self._run("fmu_allocate", SCRATCH), 0
        self.name = self._place((name or fmu.new_name()).encode() + b"\0")
        token = self._place((fmu.description.guid if token is None else token).encode() + b"\0")
        references = self._place(bytes(self.references(required)))
        self.c = self._run(
            "fmi3InstantiateCoSimulation",
            *(self.name, token, 0, 0, int(logging), int(event_mode), 0, references, len(required), self.name),
            *(self._run("fmu_log_message"), self._run("fmu_intermediate_update")),
        )

    def _run(self, function, *arguments):
        if function not in self.functions:
            self.functions[function] = self.exports[function]
        try:
            return self.functions[function](self.store, *arguments)
        except wasmtime.Trap as trap:
            raise Lost(str(trap)) from trap

    def _place(self, content):
        """Memory with this content, for good."""
        at = self._run("fmu_allocate", max(len(content), 1))
        self.memory.write(self.store, content, at)
        return at

    def _lend(self, content):
        """Memory with this content, until the next call."""
        if self.used + len(content) > SCRATCH:
            return self._place(content)
        at, self.used = self.scratch + self.used, self.used + (len(content) + 7) // 8 * 8
        self.memory.write(self.store, content, at)
        return at

    def _text(self, at, size):
        return bytes(self.memory.read(self.store, at, at + size)).decode()

    def _told(self, instance, instance_size, status, category, category_size, message, size):
        self.messages.append((status, self._text(category, category_size), self._text(message, size)))

    def _updated(self, *arguments):
        self.updates.append((*arguments[:1], *map(bool, arguments[1:5])))

    def place_file(self, path, content):
        path, content = path.encode(), content.encode()
        assert self._run("fmu_place_file", self._place(path), len(path), self._place(content), len(content)) == 0

    def status(self, function, *arguments):
        passed, returned, self.used = [self.c], [], 0
        for given in arguments:
            target = getattr(given, "_obj", given)  # of byref
            if isinstance(target, ctypes._SimpleCData) and target is given:
                passed.append(given.value if isinstance(given, c_double) else int(given.value or 0))
                continue
            if given is None:
                passed.append(0)
                continue
            narrow = isinstance(target, (c_size_t, c_void_p))  # of 4 bytes there
            if isinstance(target, ctypes.Array) and target._type_ is c_char_p:
                texts = [self._lend((text or b"") + b"\0") for text in target]
                content = b"".join(at.to_bytes(4, "little") for at in texts)
            elif narrow:
                content = int(target.value or 0).to_bytes(4, "little")
            else:
                content = bytes(target)
            at = self._lend(content)
            passed.append(at)
            if isinstance(target, ctypes.Array) and target._type_ is not c_char_p or target is not given or narrow:
                returned.append((at, target, len(content)))
            elif isinstance(target, ctypes.Array):
                returned.append((at, target, None))
        status = self._run(function, *passed)
        for at, target, size in returned:
            if size is None:
                for k in range(len(target)):
                    text = int.from_bytes(self.memory.read(self.store, at + 4 * k, at + 4 * k + 4), "little")
                    target[k] = self._c_string(text)
            elif isinstance(target, (c_size_t, c_void_p)):
                target.value = int.from_bytes(self.memory.read(self.store, at, at + 4), "little")
            else:
                ctypes.memmove(ctypes.addressof(target), bytes(self.memory.read(self.store, at, at + size)), size)
        return status

    def _c_string(self, at):
        end = at
        while self.memory.read(self.store, end, end + 1) != b"\0":
            end += 1
        return bytes(self.memory.read(self.store, at, end))

    def free(self):
        self._run("fmi3FreeInstance", self.c)


class Component(Called):
    """An instance of the resource of the component, with the methods of `fmu3.Instance3`."""

    def __init__(self, fmu, name=None, logging=True, event_mode=False, token=None, required=()):
        self.fmu, self.messages, self.updates = fmu, [], []
        self.store, linker = wasmtime.Store(ENGINE), components.Linker(ENGINE)
        with linker.root() as root:
            with root.add_instance("fmi:fmi3/callbacks@3.0.0") as callbacks:
                callbacks.add_func("log-message", self._told)
            with root.add_instance("fmi:fmi3/intermediate-update-callbacks@3.0.0") as callbacks:
                callbacks.add_func("intermediate-update", lambda _store, *arguments: self.updates.append(arguments) or (False, 0.0))
        self.instance = linker.instantiate(self.store, fmu.compiled(Component))
        self.functions = {}
        self.name = name or fmu.new_name()
        guid = fmu.description.guid if token is None else token
        references = [self.reference(name) for name in required]
        instantiate = "[static]co-simulation-instance.instantiate-co-simulation"
        self.this = self._run(instantiate, self.name, guid, "", False, logging, event_mode, False, references)

    def _function(self, name):
        if name not in self.functions:
            interface = "fmi:fmi3/common@3.0.0" if name == "get-version" else "fmi:fmi3/co-simulation@3.0.0"
            exported = self.instance.get_export_index(self.store, interface)
            self.functions[name] = self.instance.get_func(self.store, self.instance.get_export_index(self.store, name, exported))
        return self.functions[name]

    def _run(self, name, *arguments):
        function = self._function(name)
        try:
            result = function(self.store, *arguments)
            function.post_return(self.store)
            return result
        except wasmtime.WasmtimeError as error:
            raise Lost(str(error)) from error

    def _told(self, _store, instance, status, category, message):
        assert instance in (self.name, "")
        self.messages.append((STATUSES[status], category, message))

    def method(self, name, *arguments):
        """What a method gives; `Refused` where it gives a status that is not OK."""
        result = self._run(f"[method]co-simulation-instance.{name}", self.this, *arguments)
        if not isinstance(result, str):
            return result
        if result != "ok":
            raise Refused(name, STATUSES[result], self.text)

    def reference(self, name):
        return self.fmu.variables[name].valueReference

    def set(self, name, *values):
        kind = self.fmu.access(name)
        values = [float(v) if kind == "Float64" else v for v in values]
        self.method(f"set-{kind.lower()}", [self.reference(name)], values)

    def get(self, name):
        return self.method(f"get-{self.fmu.access(name).lower()}", [self.reference(name)])

    outputs = Instance3.outputs

    def initialize(self, start=0.0):
        self.method("enter-initialization-mode", None, float(start), None)
        self.method("exit-initialization-mode")
        return self

    def update(self):
        info = self.method("update-discrete-states")
        assert not any(value is True for value in vars(info).values())

    def step(self, t, h):
        done = vars(self.method("do-step", float(t), float(h), True))
        assert done["last-successful-time"] == t + h
        assert not any(done[flag] for flag in ("event-handling-needed", "terminate-simulation", "early-return"))

    def serialize(self):
        return bytes(self.method("get-fmu-state"))

    def restore(self, data):
        self.method("set-fmu-state", data)

    def derivative(self, kind, unknowns, knowns, seed):
        references = [[self.reference(n) for n in names] for names in (unknowns, knowns)]
        return self.method(f"get-{kind}-derivative", *references, seed)
