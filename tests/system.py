"""The system structure: components, connections and parameter values of an SSD file, checked; the order that the FMUs' dependencies ask for.

What this master does not support, and what does not fit, is refused with the reason (`BadSystem`) rather than skipped.
"""

import math
import zipfile
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import NamedTuple
from xml.etree import ElementTree

SSD = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"
SSC = "{http://ssp-standard.org/SSP1/SystemStructureCommon}"
SSV = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
BOND = "io.github.hdrm-fmu.power-bond"
FEEDTHROUGH = "io.github.hdrm-fmu.feedthrough"
#: What the Open Simulation Platform says of the step.
OSP = "{http://opensimulationplatform.com/SSP/OSPAnnotations}"
FMU = "application/x-fmu-sharedlibrary"

#: Types of connectors that can be connected.
CONNECTED = ("Real", "Integer", "Boolean")

#: Which way power goes where effort times flow is positive: the start element of the effort delivers it or takes it.
POWERS = ("delivered", "drawn")

#: What to do about units that differ.
UNITS = "units are never converted: where the numbers are right as they are, or are made right by a LinearTransformation, "
UNITS += 'the connection must say suppressUnitConversion="true"'

#: What breaks an algebraic loop.
REMEDY = "no order of exchange resolves it. One of these components must have a state, or a delay of a communication step, between its input "
REMEDY += "and its output, and must not list that input among the output's dependencies; or one of the connections must go"

#: Python's values of SSP's types; an enumeration stays the name of its item.
VALUES = {"Real": float, "Integer": int, "Boolean": {"true": True, "1": True, "false": False, "0": False}.__getitem__}
VALUES |= {"String": str, "Enumeration": str}

#: SSP's types that a value may have, by the type of the FMU's variable.
ACCEPTED = {"Real": ("Real", "Integer"), "Enumeration": ("Enumeration", "Integer")}
ACCEPTED |= {kind: (kind,) for kind in ("Integer", "Boolean", "String")}


class BadSystem(Exception):
    """Why a system cannot be run."""


class AlgebraicLoop(BadSystem):
    pass


class Parameter(NamedTuple):
    """A start value, its SSP type, and its unit where the set gives one."""

    value: object
    type: str
    unit: str | None


class Linear(NamedTuple):
    """What a connection makes of a Real value: factor * value + offset."""

    factor: float = 1.0
    offset: float = 0.0


#: The transformation that leaves every value as it is.
AS_IT_IS = Linear()


class Connector(NamedTuple):
    """A connector as declared: input or output, SSP type, unit."""

    kind: str
    type: str
    unit: str | None


@dataclass(frozen=True)
class Link:
    """A connection: (component, output) to (component, input). One that carries the effort of a power bond names the output with the mean
    of the effort over the last step and the input with the conjugate flow."""

    source: tuple
    target: tuple
    step_mean: str | None = None
    flow: str | None = None
    transformation: Linear = AS_IT_IS
    #: `suppressUnitConversion`: the units of the ends may differ.
    units_stay: bool = False

    def __str__(self):
        return f"{'.'.join(self.source)} -> {'.'.join(self.target)}"


def parse_xml(text, root, what):
    try:
        found = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise BadSystem(f"{what} is not a readable SSP 1.0 description: it is no XML ({error})") from None
    if found.tag != root:
        raise BadSystem(f"{what} is not a readable SSP 1.0 description: its root is {found.tag}")
    return found


def read_set(text):
    """{name: Parameter} of a parameter set's text."""
    return parameters(parse_xml(text, f"{SSV}ParameterSet", "the parameter set"))


def parameters(element, prefix=""):
    """{name: Parameter} of what is below `element`."""
    found = {}
    for parameter in element.iter(f"{SSV}Parameter"):
        name = parameter.get("name")
        if len(parameter) != 1:
            raise BadSystem(f"parameter `{name}` has no value")
        (value,) = parameter
        kind, text = value.tag.removeprefix(SSV), value.get("value")
        try:
            found[prefix + name] = Parameter(VALUES[kind](text), kind, value.get("unit"))
        except (KeyError, ValueError):
            raise BadSystem(f"parameter `{name}` = `{text}`: the value must be of type {kind}") from None
    return found


def bound(element, owner, file):
    """{name: Parameter} of the parameter bindings of a component or system; `file` gives the sets that they name."""
    found = {}
    for binding in element.iterfind(f"{SSD}ParameterBindings/{SSD}ParameterBinding"):
        source, values = binding.get("source"), binding.find(f"{SSD}ParameterValues")
        if binding.find(f"{SSD}ParameterMapping") is not None:
            raise BadSystem(f"{owner}: parameter mappings are not supported")
        if (source is None) == (values is None):
            raise BadSystem(f"{owner}: a parameter binding needs either a source or values, and not both")
        if binding.get("sourceBase", "SSD") != "SSD":
            raise BadSystem(f"{owner}: parameter set `{source}`: only sources relative to the system structure are supported")
        if source is not None:
            try:
                values = parse_xml(file(source), f"{SSV}ParameterSet", f"{owner}: parameter set `{source}`")
            except (OSError, KeyError) as error:
                raise BadSystem(f"{owner}: parameter set `{source}` cannot be read: {error}") from None
        found |= parameters(values, binding.get("prefix", ""))
    return found


def connection(element):
    """The link of an ssd:Connection."""
    ends = [element.get(name) for name in ("startElement", "startConnector", "endElement", "endConnector")]
    link = Link((ends[0], ends[1]), (ends[2], ends[3]))
    if any(name.endswith("Indices") for name in element.attrib):
        raise BadSystem(f"connection {ends[1]} -> {ends[3]}: connections of single elements of arrays by their indices are not supported")
    if None in ends:
        raise BadSystem(f"connection {ends[1]} -> {ends[3]}: both ends must name a component")
    if any(child.tag.endswith("MappingTransformation") for child in element):
        raise BadSystem(f"connection {link}: mapping transformations are not supported, only LinearTransformation")
    link = replace(link, transformation=linear(element, link), units_stay=element.get("suppressUnitConversion") in ("true", "1"))
    for annotation in element.iter(f"{SSC}Annotation"):
        bond = next((child for child in annotation if child.tag.endswith("PowerBond")), None)
        if bond is not None:
            if annotation.get("type") != BOND:
                kind = annotation.get("type")
                raise BadSystem(f"connection {link}: a PowerBond stands in an annotation of type `{kind}`; the type must be `{BOND}`")
            if bond.get("power", POWERS[0]) not in POWERS:
                raise BadSystem(f"connection {link}: power = `{bond.get('power')}` of a PowerBond must be `{'` or `'.join(POWERS)}`")
            return replace(link, step_mean=bond.get("stepMean"), flow=bond.get("flow"))
    return link


def linear(element, link):
    """The linear transformation of a connection."""
    found = element.find(f"{SSC}LinearTransformation")
    if found is None:
        return AS_IT_IS
    texts = found.get("factor", "1"), found.get("offset", "0")
    try:
        transformation = Linear(*map(float, texts))
    except ValueError:
        transformation = Linear(math.nan)
    if not all(map(math.isfinite, transformation)):
        raise BadSystem(f"connection {link}: LinearTransformation with factor {texts[0]} and offset {texts[1]}; both must be finite")
    return transformation


@dataclass
class System:
    """Components in stepping order with the name of their FMU's file, and the links between them."""

    components: dict = field(default_factory=dict)
    #: {name of an FMU's file: where the structure says that it lies}
    sources: dict = field(default_factory=dict)
    #: {(component, name): Connector}
    connectors: dict = field(default_factory=dict)
    links: list = field(default_factory=list)
    start: float = 0.0
    stop: float = 0.0
    #: Communication step that the structure asks for, s, or None.
    step: float | None = None
    #: Components whose outputs may be read again after a set, although they declare no dependencies.
    feedthrough: set = field(default_factory=set)
    #: {component: {name: Parameter}} of the parameter bindings
    parameters: dict = field(default_factory=dict)

    @classmethod
    def read(cls, path, variant="SystemStructure.ssd"):
        """Of a .ssd with its files beside it, or of a packed .ssp, there the structure named `variant`."""
        path = Path(path)
        if path.suffix != ".ssp":
            return cls.parse(path.read_bytes(), lambda name: (path.parent / name).read_bytes())
        with zipfile.ZipFile(path) as archive:
            return cls.parse(archive.read(variant), archive.read)

    @classmethod
    def parse(cls, text, file):
        """Of a text; `file` gives the parameter sets that it names."""
        root = parse_xml(text, f"{SSD}SystemStructureDescription", "the system structure")
        outer, experiment = root.find(f"{SSD}System"), root.find(f"{SSD}DefaultExperiment")
        system = cls()
        if experiment is not None:
            system.start, system.stop = float(experiment.get("startTime", 0.0)), float(experiment.get("stopTime", 0.0))
            steps = [float(a.get("baseStepSize")) for a in experiment.iter(f"{OSP}FixedStepAlgorithm")]
            system.step = steps[0] if steps else None
        owner = f"system `{outer.get('name')}`"
        if outer.find(f"{SSD}Connectors/{SSD}Connector") is not None:
            raise BadSystem(f"{owner}: connectors of the outer system are not supported")
        for element in outer.iterfind(f"{SSD}Elements/*"):
            system._add(element, owner, file)
        system.links = [system._directed(connection(element)) for element in outer.iterfind(f"{SSD}Connections/{SSD}Connection")]
        system._check_links()
        for name, parameter in bound(outer, owner, file).items():
            component, _, variable = name.partition(".")
            if component not in system.components:
                raise BadSystem(f"{owner}: `{name}` is not a variable of one of its components, component.variable")
            system.parameters[component][variable] = parameter
        return system

    def _add(self, element, owner, file):
        name = element.get("name")
        if element.tag != f"{SSD}Component":
            kind = "nested system" if element.tag == f"{SSD}System" else "element"
            raise BadSystem(f"{owner}: the {kind} `{name}` is not supported, only components")
        if name in self.components:
            raise BadSystem(f"the system has two components named `{name}`")
        source, kind = element.get("source"), element.get("type", FMU)
        if source is None or kind != FMU or PurePosixPath(source).suffix in (".ssd", ".ssp"):
            raise BadSystem(f"component `{name}` is `{source}` of type {kind}; only FMUs, of type {FMU}, are supported")
        fmu = PurePosixPath(source).name
        if self.sources.setdefault(fmu, source) != source:
            raise BadSystem(f"the FMUs `{self.sources[fmu]}` and `{source}` have the same file name, by which this master tells FMUs apart")
        self.components[name] = fmu
        if any(a.get("type") == FEEDTHROUGH for a in element.iter(f"{SSC}Annotation")):
            self.feedthrough.add(name)
        self.parameters[name] = bound(element, f"component `{name}`", file)
        for connector in element.iterfind(f"{SSD}Connectors/{SSD}Connector"):
            types = [child for child in connector if child.tag.startswith(SSC)]
            kind, unit = (types[0].tag.removeprefix(SSC), types[0].get("unit")) if types else ("nothing", None)
            self.connectors[name, connector.get("name")] = Connector(connector.get("kind"), kind, unit)

    def _directed(self, link):
        """The link from an output to an input; a structure may name its ends in either order."""
        kinds = [self.connectors[end].kind if end in self.connectors else None for end in (link.source, link.target)]
        return replace(link, source=link.target, target=link.source) if kinds == ["input", "output"] else link

    def _check_links(self):
        """Each link must join declared connectors, an output and an input, of the same type and unit, every input at most once."""
        driven = {}
        for link in self.links:
            start, end = self._connector(link.source, "output"), self._connector(link.target, "input")
            if start.type != end.type:
                raise BadSystem(f"connection {link}: the types differ, {start.type} and {end.type}; both ends must be of the same type")
            if start.unit != end.unit and not link.units_stay:
                raise BadSystem(f"connection {link}: the units differ, `{start.unit or 'none'}` and `{end.unit or 'none'}`; {UNITS}")
            if link.transformation != AS_IT_IS and start.type != "Real":
                raise BadSystem(f"connection {link}: a LinearTransformation is for Real connectors; these are {start.type}")
            if link.target in driven:
                first, second = driven[link.target], ".".join(link.source)
                raise BadSystem(f"input {'.'.join(link.target)} is driven twice, by {first} and by {second}")
            driven[link.target] = ".".join(link.source)

    def _connector(self, end, kind):
        component, name = end
        if component not in self.components:
            raise BadSystem(f"a connection names the component `{component}`, which the system does not have")
        if end not in self.connectors:
            raise BadSystem(f"component `{component}` declares no connector `{name}`, but a connection uses it")
        found = self.connectors[end]
        if found.kind != kind:
            raise BadSystem(f"connector `{component}.{name}` is declared as {found.kind}, but a connection uses it as {kind}")
        if found.type not in CONNECTED:
            types = ", ".join(CONNECTED)
            raise BadSystem(f"connector `{component}.{name}` is declared as {found.type}; only connectors of the types {types} can be connected")
        return found

    def check(self, fmus):
        """Connectors, links and parameters against the FMUs by file name. A unit that an FMU does not tell is not checked."""
        variable = lambda component, name: described(fmus[self.components[component]], name)
        for (component, name), connector in self.connectors.items():
            found = fmus[self.components[component]].variables.get(name)
            unit = found and unit_of(found)
            if connector.unit and unit and connector.unit != unit:
                raise BadSystem(f"connector `{component}.{name}` is declared in `{connector.unit}`, but its FMU has it in `{unit}`")
        for link in self.links:
            units = []
            for (component, name), causality in ((link.source, "output"), (link.target, "input")):
                found, kind = variable(component, name), self.connectors[link.source].type
                if (found.type, found.causality) != (kind, causality):
                    raise BadSystem(
                        f"{component}.{name} must be of type {kind}, {causality}, to be connected; it is of type {found.type}, {found.causality}"
                    )
                units.append(unit_of(found))
            if all(units) and units[0] != units[1] and not link.units_stay:
                raise BadSystem(f"connection {link}: the FMUs' units differ, `{units[0]}` and `{units[1]}`; {UNITS}")
            self._check_bond(link, variable)
        for component, values in self.parameters.items():
            for name, parameter in values.items():
                check_parameter(f"{component}.{name}", parameter, variable(component, name))

    def _check_bond(self, link, variable):
        if link.step_mean is None:
            return
        component, _ = link.source
        for name in (link.step_mean, link.flow):
            variable(component, name)
        if not any(other.target == (component, link.flow) for other in self.links):
            effort = ".".join(link.source)
            raise BadSystem(f"power bond of {effort}: no connection drives its flow {component}.{link.flow}")


def described(fmu, name):
    """A variable of an FMU."""
    if name not in fmu.variables:
        raise BadSystem(f"model `{fmu.description.modelName}` has no variable `{name}`")
    return fmu.variables[name]


def unit_of(variable):
    """Unit of a variable or of its type, or None."""
    return variable.unit or (variable.declaredType.unit if variable.declaredType else None)


def check_parameter(name, parameter, variable):
    """A start value must be of the type, the unit and, for an enumeration by name, the items of its variable."""
    value, kind, unit = parameter
    if kind not in ACCEPTED[variable.type]:
        raise BadSystem(f"`{name}` = {value}: given as {kind}, but the variable is of type {variable.type}")
    if unit is not None and unit != unit_of(variable):
        raise BadSystem(f"`{name}` = {value} in `{unit}`: the unit must be the unit of the variable, `{unit_of(variable)}`")
    items = [item.name for item in variable.declaredType.items] if variable.type == "Enumeration" else []
    if kind == "Enumeration" and value not in items:
        raise BadSystem(f"`{name}` = `{value}` must be one of {', '.join(items)}")


def feedthrough(fmu, initialization, declared_only=False):
    """Inputs that each output depends on, by name, as the model structure says; where it does not say it, all or none."""
    inputs = [] if declared_only else fmu.names("input")
    return {
        u.variable.name: inputs if u.dependencies is None else [v.name for v in u.dependencies if v.causality == "input"]
        for u in fmu.unknowns(initialization)
        if u.variable.causality == "output"
    }


def is_read_once(system, fmus, link):
    """Whether an output is read right after the step only, before any input is set: its dependencies are not declared."""
    component, output = link.source
    listed = fmus[system.components[component]].unknowns(False)
    is_declared = any(u.variable.name == output and u.dependencies is not None for u in listed)
    return component not in system.feedthrough and not is_declared


def levels(system, fmus, initialization=False, declared_only=False):
    """Level of each link: 0 if its output depends on no connected input, else one more than the links it depends on. An output whose
    dependencies are not declared depends on all inputs in initialization, or with `declared_only` on none; afterwards it is read once."""
    through = {name: feedthrough(fmus[file], initialization, declared_only) for name, file in system.components.items()}
    if not initialization:
        for link in system.links:
            if is_read_once(system, fmus, link):
                through[link.source[0]][link.source[1]] = []
    into = {link.target: link for link in system.links}
    found, under_way = {}, []

    def level(link):
        if link in found:
            return found[link]
        if link in under_way:
            ends = under_way[under_way.index(link) :] + [link]
            raise AlgebraicLoop("algebraic loop: " + " -> ".join(".".join(end.source) for end in ends) + f"; {REMEDY}")
        under_way.append(link)
        component, output = link.source
        before = [into[component, i] for i in through[component].get(output, []) if (component, i) in into]
        found[link] = 1 + max(map(level, before), default=-1)
        under_way.pop()
        return found[link]

    return [level(link) for link in system.links]
