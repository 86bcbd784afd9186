"""The system structure: components and connections of an SSD file, sorted by the FMUs' dependencies; parameter sets."""

import zipfile
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

SSD = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"
SSC = "{http://ssp-standard.org/SSP1/SystemStructureCommon}"
SSV = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
BOND = "{urn:cosim:power-bond}PowerBond"

#: Python's values of SSP's types; an enumeration stays the name of its item.
VALUES = {"Real": float, "Integer": int, "Boolean": lambda text: text in ("true", "1"), "String": str, "Enumeration": str}


def parameters(element):
    """{name: value} of what is below `element`."""
    found = {}
    for parameter in element.iter(f"{SSV}Parameter"):
        (value,) = parameter
        found[parameter.get("name")] = VALUES[value.tag.removeprefix(SSV)](value.get("value"))
    return found


def read_set(text):
    """{name: value} of a parameter set."""
    return parameters(ElementTree.fromstring(text))


@dataclass(frozen=True)
class Link:
    """A connection: (component, output) to (component, input); `step_mean` as in the power-bond annotation."""

    source: tuple
    target: tuple
    step_mean: str | None = None


@dataclass
class System:
    """Components in stepping order with the name of their FMU's file, and the links between them."""

    components: dict = field(default_factory=dict)
    units: dict = field(default_factory=dict)
    links: list = field(default_factory=list)
    stop: float = 0.0
    #: {component: {parameter: value}} of the parameter bindings
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
        root = ElementTree.fromstring(text)
        system = cls(stop=float(root.find(f"{SSD}DefaultExperiment").get("stopTime")))
        for component in root.iter(f"{SSD}Component"):
            name = component.get("name")
            system.components[name] = PurePosixPath(component.get("source")).name
            for connector in component.iter(f"{SSD}Connector"):
                real = connector.find(f"{SSC}Real")
                system.units[name, connector.get("name")] = (connector.get("kind"), real.get("unit"))
            system.parameters[name] = values = {}
            for binding in component.iter(f"{SSD}ParameterBinding"):
                source = binding.get("source")
                values |= parameters(binding) if source is None else read_set(file(source))
        for c in root.iter(f"{SSD}Connection"):
            bond = next(c.iter(BOND), None)
            system.links.append(
                Link(
                    (c.get("startElement"), c.get("startConnector")),
                    (c.get("endElement"), c.get("endConnector")),
                    None if bond is None else bond.get("stepMean"),
                )
            )
        return system


def feedthrough(fmu, initialization):
    """Inputs that each output depends on, by name, as the model structure says."""
    inputs = fmu.names("input")
    unknowns = fmu.description.initialUnknowns if initialization else fmu.description.outputs
    return {
        u.variable.name: inputs if u.dependencies is None else [v.name for v in u.dependencies if v.causality == "input"]
        for u in unknowns
        if u.variable.causality == "output"
    }


class AlgebraicLoop(Exception):
    pass


def levels(system, fmus, initialization=False):
    """Level of each link: 0 if its output depends on no connected input, else one more than the links it depends on."""
    through = {name: feedthrough(fmus[file], initialization) for name, file in system.components.items()}
    into = {link.target: link for link in system.links}
    found, under_way = {}, []

    def level(link):
        if link in found:
            return found[link]
        if link in under_way:
            ends = under_way[under_way.index(link) :] + [link]
            raise AlgebraicLoop(" -> ".join(".".join(end.source) for end in ends))
        under_way.append(link)
        component, output = link.source
        before = [into[component, i] for i in through[component].get(output, []) if (component, i) in into]
        found[link] = 1 + max(map(level, before), default=-1)
        under_way.pop()
        return found[link]

    return [level(link) for link in system.links]
