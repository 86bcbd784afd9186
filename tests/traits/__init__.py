"""Small FMUs that misbehave on request (`traits.c`), of FMI 2.0 and 3.0, and systems of them: for tests of what programs do with options and faults.

Each integrates its input `u`; from the step on that reaches the time `at` it is of the `kind` of TRAITS.
"""

import subprocess
import zipfile
from pathlib import Path

#: Kinds by their number in `traits.c`.
TRAITS = ("good", "not a number", "fails", "discards", "terminates", "exits", "aborts", "crashes", "infinite", "z is not a number", "destroys")


def compiled(folder):
    """The library; needs a C compiler."""
    library = Path(folder) / "traits.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", library, Path(__file__).parent / "traits.c", "-lm"], check=True)
    return library


#: Name, reference, causality, variability, start.
VARIABLES = [
    ("u", 1, "input", "continuous", "0"),
    ("y", 2, "output", "continuous", None),
    ("y_mean", 3, "output", "continuous", None),
    ("x", 4, "local", "continuous", "0"),
    ("k", 5, "parameter", "tunable", "1"),
    ("d", 6, "parameter", "fixed", "0"),
    ("at", 7, "parameter", "fixed", "1e9"),
    ("z", 8, "output", "continuous", None),
    ("kind", 10, "parameter", "fixed", "0"),
    ("n", 11, "input", "discrete", "0"),
    ("m", 12, "output", "discrete", None),
]


def description(version, on, flags, step):
    """The model description; `on` are the inputs on which y depends at once, None where nothing is said of that."""
    experiment = f'<DefaultExperiment startTime="0" stopTime="1" stepSize="{step}"/>'
    variables, outputs = "", ""
    for index, (name, reference, causality, variability, start) in enumerate(VARIABLES, 1):
        whole = reference >= 10
        say = f'name="{name}" valueReference="{reference}" causality="{causality}" variability="{variability}"'
        start = "" if start is None else f' start="{start}"'
        # y, and m of n, depend on inputs; z and y_mean on nothing.
        depends = {"y": on, "m": "n"}.get(name, "")
        if version == 2:
            variables += f'<ScalarVariable {say}{" initial=" + chr(34) + "exact" + chr(34) if name == "x" else ""}><{"Integer" if whole else "Real"}{start}/></ScalarVariable>'
            index_of = {v[0]: k for k, v in enumerate(VARIABLES, 1)}
            depends = depends if depends is None or not depends else str(index_of[depends])
            unknown = f'<Unknown index="{index}"'
        else:
            variables += f'<{"Int32" if whole else "Float64"} {say}{start}{" initial=" + chr(34) + "exact" + chr(34) if name == "x" else ""}/>'
            depends = depends if depends is None or not depends else {"u": "1", "n": "11"}[depends]
            unknown = f'<Output valueReference="{reference}"'
        if causality == "output":
            outputs += unknown + ("" if depends is None else f' dependencies="{depends}"') + "/>"
    able = f'modelIdentifier="traits" {flags}'
    if version == 2:
        able += ' canInterpolateInputs="true" maxOutputDerivativeOrder="1" canGetAndSetFMUstate="true" canSerializeFMUstate="true"'
        head, structure = 'fmiVersion="2.0" guid="t"', f"<Outputs>{outputs}</Outputs>"
    else:
        able += ' maxOutputDerivativeOrder="1" canGetAndSetFMUState="true" canSerializeFMUState="true"'
        head, structure = 'fmiVersion="3.0" instantiationToken="t"', outputs
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<fmiModelDescription modelName="traits" {head}><CoSimulation {able}/>{experiment if version == 2 else ""}'
        f"{'' if version == 2 else experiment}<ModelVariables>{variables}</ModelVariables><ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )


def pack(file, library, version=2, on="", flags='canHandleVariableCommunicationStepSize="true"', step="0.1"):
    """An FMU at `file`."""
    folder = {2: "linux64", 3: "x86_64-linux"}[version]
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("modelDescription.xml", description(version, on, flags, step))
        archive.write(library, f"binaries/{folder}/traits.so")
    return file


def _component(name, source):
    connectors = "".join(f'<ssd:Connector name="{v[0]}" kind="{v[2]}"/>' for v in VARIABLES if v[2] in ("input", "output"))
    return f'<ssd:Component name="{name}" source="{source}"><ssd:Connectors>{connectors}</ssd:Connectors></ssd:Component>'


def _connection(start, end, bond=""):
    (a, y), (b, u) = start.split("."), end.split(".")
    return f'<ssd:Connection startElement="{a}" startConnector="{y}" endElement="{b}" endConnector="{u}">{bond}</ssd:Connection>'


BOND = (
    '<ssd:Annotations><ssc:Annotation type="io.github.hdrm-fmu.power-bond"><PowerBond stepMean="y_mean" flow="u"/></ssc:Annotation></ssd:Annotations>'
)


def structure(components, connections, parameters=""):
    """A system structure: components {name: source}, connections [(start, end)] with the power bond on those from `spring`."""
    elements = "".join(_component(*c) for c in components.items())
    links = "".join(_connection(a, b, BOND if a.startswith("spring.") else "") for a, b in connections)
    return (
        '<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" '
        'xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" '
        f'version="1.0" name="s"><ssd:System name="s">{parameters}<ssd:Elements>{elements}</ssd:Elements><ssd:Connections>{links}</ssd:Connections>'
        '</ssd:System><ssd:DefaultExperiment startTime="0" stopTime="1"/></ssd:SystemStructureDescription>'
    )


def parameter_set(values):
    """The text of a parameter set of Reals and Integers."""
    rows = ""
    for name, value in values.items():
        kind = "Integer" if isinstance(value, int) else "Real"
        rows += f'<ssv:Parameter name="{name}"><ssv:{kind} value="{value}"/></ssv:Parameter>'
    return (
        '<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="p">'
        f"<ssv:Parameters>{rows}</ssv:Parameters></ssv:ParameterSet>"
    )


#: A spring, whose force is its elongation times k, and a mass, whose velocity is its output: an oscillator with a power bond.
OSCILLATOR = [("mass.y", "spring.u"), ("spring.y", "mass.u")]


def oscillator(file, fmu, structures=None):
    """The oscillator as a package, with further structures by name."""
    components = {"spring": "resources/unit.fmu", "mass": "resources/unit.fmu"}
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("SystemStructure.ssd", structure(components, OSCILLATOR))
        for name, text in (structures or {}).items():
            archive.writestr(name, text)
        archive.write(fmu, "resources/unit.fmu")
    return file
