"""Loading takes time in proportion to the size of a system: four times the connections, columns or events take four times the instructions.

valgrind counts instructions, which do not depend on how busy the machine is. From n to 2n to 4n the second step may take 2.3 times the
instructions of the first: 2 is linear, 4 would be quadratic. The FMUs have an empty library; runs end when their functions are looked up.
"""

import json
import re
import shutil
import subprocess
import zipfile

import pytest

from native import program

pytestmark = pytest.mark.skipif(not shutil.which("valgrind") or not shutil.which("cc"), reason="needs valgrind and a C compiler")
SIZES = (100, 200, 400)
SSD = "<ssd:SystemStructureDescription xmlns:ssd='d' xmlns:ssc='c' xmlns:ssv='v' version='1.0' name='s'><ssd:System name='s'>{}</ssd:System></ssd:SystemStructureDescription>"


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    folder = tmp_path_factory.mktemp("library")
    (folder / "empty.c").write_text("int nothing;")
    subprocess.run(["cc", "-shared", "-fPIC", "empty.c", "-o", "M.so"], cwd=folder, check=True)
    return (folder / "M.so").read_bytes()


def fmu(path, library, pairs, declared):
    """An FMU with `pairs` inputs and outputs, each output dependent on the input of its number, or on what is not declared."""
    variables, listed = "", ""
    for k in range(pairs):
        variables += f"<ScalarVariable name='u{k}' valueReference='{2 * k}' causality='input'><Real start='0'/></ScalarVariable>"
        variables += f"<ScalarVariable name='y{k}' valueReference='{2 * k + 1}' causality='output'><Real/></ScalarVariable>"
        listed += f"<Unknown index='{2 * k + 2}'" + (f" dependencies='{2 * k + 1}'/>" if declared else "/>")
    text = f"""<fmiModelDescription fmiVersion="2.0" modelName="M" guid="g"><CoSimulation modelIdentifier="M"/><ModelVariables>{variables}</ModelVariables>
        <ModelStructure><Outputs>{listed}</Outputs></ModelStructure></fmiModelDescription>"""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", text)
        archive.writestr("binaries/linux64/M.so", library)


def element(name, source, pairs):
    kinds = [(letter + str(k), kind) for k in range(pairs) for letter, kind in (("u", "input"), ("y", "output"))]
    connectors = "".join(f"<ssd:Connector name='{name}' kind='{kind}'><ssc:Real/></ssd:Connector>" for name, kind in kinds)
    return f"<ssd:Component name='{name}' source='{source}'><ssd:Connectors>{connectors}</ssd:Connectors></ssd:Component>"


def wire(a, y, b, u):
    return f"<ssd:Connection startElement='{a}' startConnector='{y}' endElement='{b}' endConnector='{u}'/>"


def wide(n, library, folder, declared=True):
    """Two FMUs, n wires from one to the other."""
    fmu(folder / "M.fmu", library, n, declared)
    wires = "".join(wire("a", f"y{k}", "b", f"u{k}") for k in range(n))
    elements = element("a", "M.fmu", n) + element("b", "M.fmu", n)
    (folder / "s.ssd").write_text(SSD.format(f"<ssd:Elements>{elements}</ssd:Elements><ssd:Connections>{wires}</ssd:Connections>"))
    return ["wiring", "--system", folder / "s.ssd"]


def undeclared(n, library, folder):
    return wide(n, library, folder, declared=False)


def chain(n, library, folder):
    """n components, each wired to the next, with a value for each from outside."""
    fmu(folder / "M.fmu", library, 1, True)
    wires = "".join(wire(f"c{k}", "y0", f"c{k + 1}", "u0") for k in range(n - 1))
    values = "".join(f"<ssv:Parameter name='c{k}.u0'><ssv:Real value='1'/></ssv:Parameter>" for k in range(n))
    bound = f"<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues><ssv:ParameterSet version='1.0' name='p'><ssv:Parameters>{values}</ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>"
    elements = "".join(element(f"c{k}", "M.fmu", 1) for k in range(n))
    (folder / "s.ssd").write_text(SSD.format(f"{bound}<ssd:Elements>{elements}</ssd:Elements><ssd:Connections>{wires}</ssd:Connections>"))
    return ["wiring", "--system", folder / "s.ssd"]


def columns(n, library, folder):
    wide(n, library, folder)
    names = [f"a.u{k}" for k in range(n)]
    (folder / "in.csv").write_text("time," + ",".join(names) + "\n0" + ",1" * n + "\n1" + ",2" * n + "\n")
    (folder / "in.units.csv").write_text("signal,unit\ntime,s\n" + "".join(f"{name},1\n" for name in names))
    return ["run", "--quiet", "--threads", "1", "--stop-time", "1", "--system", folder / "s.ssd", "--input", folder / "in.csv"]


def events(n, library, folder):
    wide(n, library, folder)
    event = {"model": "b", "action": "override", "value": 1}
    listed = [event | {"time": 1e-3 * k, "variable": f"u{k % (n // 2)}"} for k in range(n)]
    (folder / "s.json").write_text(json.dumps({"events": listed}))
    return ["run", "--quiet", "--threads", "1", "--stop-time", "1", "--system", folder / "s.ssd", "--scenario", folder / "s.json"]


@pytest.mark.parametrize("case", [wide, undeclared, chain, columns, events], ids=lambda case: case.__name__)
def test_loading_is_linear(case, library, tmp_path):
    counts = []
    for n in SIZES:
        folder = tmp_path / str(n)
        folder.mkdir()
        arguments = map(str, case(n, library, folder))
        counted = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", str(program("cosim")), *arguments]
        done = subprocess.run(counted, capture_output=True, text=True, timeout=300)
        is_run = case in (columns, events)
        assert done.returncode == is_run and (not is_run or "fmi2" in done.stderr), done.stderr
        counts.append(int(re.search(r"Collected : (\d+)", done.stderr)[1]))
    first, second = counts[1] - counts[0], counts[2] - counts[1]
    assert second < 2.3 * first, counts
