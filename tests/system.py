"""The system structure: components and connections of an SSD file, sorted by the FMUs' dependencies."""

from dataclasses import dataclass, field
from pathlib import PurePosixPath
from xml.etree import ElementTree

SSD = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"
SSC = "{http://ssp-standard.org/SSP1/SystemStructureCommon}"
SSV = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
BOND = "{urn:cosim:power-bond}PowerBond"


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
    #: {component: {parameter: value}} of the inline parameter bindings
    parameters: dict = field(default_factory=dict)

    @classmethod
    def read(cls, path):
        root = ElementTree.parse(path).getroot()
        system = cls(stop=float(root.find(f"{SSD}DefaultExperiment").get("stopTime")))
        for component in root.iter(f"{SSD}Component"):
            name = component.get("name")
            system.components[name] = PurePosixPath(component.get("source")).name
            for connector in component.iter(f"{SSD}Connector"):
                real = connector.find(f"{SSC}Real")
                system.units[name, connector.get("name")] = (connector.get("kind"), real.get("unit"))
            system.parameters[name] = {
                parameter.get("name"): float(parameter.find(f"{SSV}Real").get("value"))
                for parameter in component.iter(f"{SSV}Parameter")
            }
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
