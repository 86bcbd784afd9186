"""CAN by FMI-LS-BUS: the examples of fmu-export, two nodes and a bus, driven through FMPy as the layered standard says, with operations
written and read here by its tables."""

import random
import struct
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import pyssp_standard
import pytest
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from lxml import etree

from conftest import FMU_DIR
from fmpy_master import ROOT
from native import cargo_fmu, recorded

FOLDER = ROOT / "kit/fmu-export/example-can"
MIME_TYPE = 'application/org.fmi-standard.fmi-ls-bus.can; version="1.0.0"'
PORTS = {"CanNode": ["can"], "CanBus": ["node[1]", "node[2]"]}
#: Communication step, s; a frame of 8 bytes has 47 + 64 bits, 222 us at 500 kbit/s.
H = 1e-4


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """The archives of FMI 3.0; there are none of FMI 2.0, which has no Binary."""
    out = tmp_path_factory.mktemp("can")
    packages = [option for name in ("node", "bus") for option in ("-p", f"fmu-can-{name}")]
    done = cargo_fmu("pack", "--profile", "release", *packages, "--out", out, cwd=ROOT, environment={"CARGO_TARGET_DIR": str(FMU_DIR.parent)})
    assert done.returncode == 0, done.stderr
    assert "not packed for FMI 2.0" in done.stderr and not list(out.glob("*.fmu"))
    return out / "fmi3"


@pytest.mark.parametrize("name", PORTS)
def test_archives_are_those_of_the_layered_standard(fmus, name):
    archive = fmus / f"{name}.fmu"
    # FMPy expects output clocks among the initial unknowns, although fmi3GetClock is not allowed in Initialization Mode [FMI 3.0.2, 2.3.3], and no
    # clocked variables, which may be there [2.4.8].
    assert [problem for problem in validate_fmu(str(archive)) if "InitialUnknowns" not in problem] == []
    done = cargo_fmu("check", archive)
    assert done.returncode == 0 and " 0 failed" in done.stdout, done.stdout
    done = cargo_fmu("verify", archive, "--write", fmus / "out.csv")
    assert done.returncode == 1 and "Rx_Clock` is triggered, in Event Mode" in done.stderr, done.stderr
    with zipfile.ZipFile(archive) as opened:
        manifest = ElementTree.fromstring(opened.read("extra/org.fmi-standard.fmi-ls-bus/fmi-ls-manifest.xml"))
        terminals = ElementTree.fromstring(opened.read("terminalsAndIcons/terminalsAndIcons.xml"))
        description = ElementTree.fromstring(opened.read("modelDescription.xml"))
    space = "{http://fmi-standard.org/fmi-ls-manifest}fmi-ls-"
    assert manifest.tag == "fmiLayeredStandardManifest"
    assert manifest.attrib == {
        f"{space}name": "org.fmi-standard.fmi-ls-bus",
        f"{space}version": "1.0.0",
        f"{space}description": "Layered Standard for the simulation of bus communication on a Physical Signal Abstraction or Network Abstraction "
        "based level.",
        "isBusSimulationFMU": "true" if name == "CanBus" else "false",
    }
    variables = {v.get("name"): v for v in description.find("ModelVariables")}
    found = terminals.findall("Terminals/Terminal")
    assert [terminal.get("name") for terminal in found] == PORTS[name]
    for terminal in found:
        port = terminal.get("name")
        assert terminal.get("terminalKind") == "org.fmi-ls-bus.network-terminal" and terminal.get("matchingRule") == "org.fmi-ls-bus.transceiver"
        members = {m.get("memberName"): m.get("variableName") for m in terminal.findall("TerminalMemberVariable")}
        assert members == {member: f"{port}.{member}" for member in ("Rx_Data", "Rx_Clock", "Tx_Data", "Tx_Clock")}
        assert {m.get("variableKind") for m in terminal.iter("TerminalMemberVariable")} == {"signal"}
        (configuration,) = terminal.findall("Terminal")
        kind = "org.fmi-ls-bus.network-terminal.configuration"
        assert configuration.attrib == {"name": "Configuration", "matchingRule": "bus", "terminalKind": kind}
        (notifications,) = configuration
        assert notifications.get("memberName") == "BusNotifications" and notifications.get("variableName") == f"{port}.BusNotifications"
        # A bus on which they can be turned off calculates whether there are any [FMI-LS-BUS 1.0, 4.4.1.3].
        expected = {"causality": "parameter", "start": "false"} if name == "CanNode" else {"causality": "calculatedParameter"}
        assert variables[f"{port}.BusNotifications"].tag == "Boolean"
        assert variables[f"{port}.BusNotifications"].attrib.items() >= (expected | {"variability": "fixed"}).items()
        for direction, causality in [("Rx", "input"), ("Tx", "output")]:
            data, clock = variables[f"{port}.{direction}_Data"], variables[f"{port}.{direction}_Clock"]
            assert (data.tag, data.get("causality"), data.get("mimeType")) == ("Binary", causality, MIME_TYPE)
            assert (clock.tag, clock.get("causality"), clock.get("intervalVariability")) == ("Clock", causality, "triggered")
            assert data.get("clocks") == clock.get("valueReference")


class Peer:
    """An instance in Co-Simulation with Event Mode."""

    def __init__(self, archive, folder, **start):
        description = fmpy.read_model_description(str(archive), validate=False)
        self.at = {v.name: v.valueReference for v in description.modelVariables}
        self.fmu = FMU3Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(str(archive), str(folder)),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=folder.name,
        )
        self.messages = []
        self.fmu.instantiate(eventModeUsed=True, loggingOn=True, logMessage=lambda environment, status, category, text: self.messages.append(text.decode()))
        self.fmu.enterInitializationMode()
        types = {v.name: v.type for v in description.modelVariables}
        for name, value in start.items():
            name = name.replace("__", ".")
            getattr(self.fmu, f"set{types[name]}")([self.at[name]], [value])
        self.fmu.exitInitializationMode()

    def sent(self, port):
        """Sent operations if `Tx_Clock` ticks, else None."""
        if not self.fmu.getClock([self.at[f"{port}.Tx_Clock"]])[0]:
            return None
        return self.fmu.getBinary([self.at[f"{port}.Tx_Data"]])[0]

    def receive(self, port, data):
        self.fmu.setClock([self.at[f"{port}.Rx_Clock"]], [True])
        self.fmu.setBinary([self.at[f"{port}.Rx_Data"]], [data])

    def integers(self, *names):
        return [self.fmu.getInt32([self.at[name]])[0] for name in names]

    def step(self, t):
        event, terminate, early, last = self.fmu.doStep(currentCommunicationPoint=t, communicationStepSize=H)
        assert not terminate and not early and abs(last - t - H) < 1e-12
        return event


class Network:
    """Peers, and wires between their ports, by FMI 3.0, 2.3.5: what ticks passes; then all go on to the next instant."""

    def __init__(self, peers, wires):
        self.peers, self.wires = peers, wires
        self.seen = []  # time, sender's wire, bytes
        self.events(0.0)

    def events(self, t):
        for instant in range(20):
            sent = [(k, *end, data) for k, (start, end) in enumerate(self.wires) if (data := start[0].sent(start[1]))]
            for k, peer, port, data in sent:
                self.seen.append((t, k, data))
                peer.receive(port, data)
            updates = [peer.fmu.updateDiscreteStates()[0] for peer in self.peers]
            if not any(updates):
                break
        assert instant < 19
        for peer in self.peers:
            peer.fmu.enterStepMode()

    def run(self, steps, first=0):
        for k in range(first, first + steps):
            needs = [peer.step(k * H) for peer in self.peers]
            for peer in self.peers:
                peer.fmu.enterEventMode()
            before = len(self.seen)
            self.events((k + 1) * H)
            assert any(needs) or len(self.seen) == before, "eventHandlingNeeded tells of what is sent"


def network(fmus, tmp_path, node_1, node_2):
    peers = [Peer(fmus / f"{kind}.fmu", tmp_path / name, **start) for kind, name, start in
             [("CanNode", "node_1", node_1), ("CanNode", "node_2", node_2), ("CanBus", "bus", {})]]
    first, second, bus = peers
    wires = []
    for node, port in [(first, "node[1]"), (second, "node[2]")]:
        wires += [((node, "can"), (bus, port)), ((bus, port), (node, "can"))]
    return Network(peers, wires)


def operation(code, arguments):
    return struct.pack("<II", code, 8 + len(arguments)) + arguments


def transmit(identifier, value):
    return operation(0x10, struct.pack("<IBBHd", identifier, 0, 0, 8, value))


def configured(behavior):
    return operation(0x40, struct.pack("<BI", 1, 500_000)) + operation(0x40, bytes([4, behavior]))


def confirm(identifier):
    return operation(0x20, struct.pack("<I", identifier))


def test_two_nodes_and_a_bus_with_arbitration(fmus, tmp_path):
    """Both nodes send at each 10 ms. The lesser identifier, of node 2, is first; the bus keeps the other, which follows."""
    start = {"can__BusNotifications": True}
    run = network(fmus, tmp_path, {"id": 257, "u": 1.25, **start}, {"id": 256, "u": -3.5, **start})
    run.run(305)
    first, second = transmit(257, 1.25), transmit(256, -3.5)
    expected = [(0, 0, configured(1)), (0, 2, configured(1))]
    # 222 us after the nodes send, and 444 us, at the next communication points.
    for period in (100, 200, 300):
        expected += [(period, 0, first), (period, 2, second)]
        expected += [(period + 3, 1, second), (period + 3, 3, confirm(256))]
        expected += [(period + 5, 1, confirm(257)), (period + 5, 3, first)]
    assert [(round(t / H), wire, data) for t, wire, data in run.seen] == expected
    node_1, node_2, bus = run.peers
    names = ("received", "sent", "confirmed", "lost")
    assert node_1.integers(*names) == node_2.integers(*names) == [3, 3, 3, 0]
    assert bus.integers("frames", "lost") == [6, 3]
    assert [node.fmu.getFloat64([node.at["y"]])[0] for node in (node_1, node_2)] == [-3.5, 1.25]
    assert not [text for peer in run.peers for text in peer.messages if "received" in text or "sends" in text]


def test_a_discarded_frame_is_sent_again(fmus, tmp_path):
    start = {"can__BusNotifications": True, "discards": True}
    run = network(fmus, tmp_path, {"id": 257, "u": 1.25, **start}, {"id": 256, "u": -3.5, **start})
    run.run(110)
    first, second = transmit(257, 1.25), transmit(256, -3.5)
    lost = operation(0x30, struct.pack("<I", 257))
    expected = [(0, 0, configured(2)), (0, 2, configured(2)), (100, 0, first), (100, 2, second)]
    # Arbitration is lost in the step after; the node answers at once, in a later instant of the same time.
    expected += [(101, 1, lost), (101, 0, first)]
    expected += [(103, 1, second), (103, 3, confirm(256)), (105, 1, confirm(257)), (105, 3, first)]
    assert [(round(t / H), wire, data) for t, wire, data in run.seen] == expected
    assert run.peers[0].integers("received", "sent", "confirmed", "lost") == [1, 2, 1, 1]


def test_a_node_that_expects_no_notifications_ignores_them(fmus, tmp_path):
    run = network(fmus, tmp_path, {"id": 257, "discards": True}, {"id": 256})
    run.run(110)
    node_1, node_2, bus = run.peers
    assert node_1.integers("received", "sent", "confirmed", "lost") == [1, 1, 0, 0], "its frame was discarded, and is not sent again"
    assert node_2.integers("received", "sent", "confirmed", "lost") == [0, 1, 0, 0], "its frame was confirmed"
    assert bus.integers("frames", "lost") == [1, 1]


@pytest.mark.parametrize("name", PORTS)
def test_any_bytes_have_an_answer(fmus, tmp_path, name):
    """A hostile peer: every value is accepted, and answered by a Format Error for each corrupt operation."""
    peer = Peer(fmus / f"{name}.fmu", tmp_path / name)
    port = PORTS[name][0]
    for _ in range(3):
        peer.fmu.updateDiscreteStates()
    generator = random.Random(7)
    corrupt = 0
    for k in range(2000):
        data = generator.randbytes(generator.randrange(60)) if k % 2 else operation(generator.randrange(2, 0x50), generator.randbytes(generator.randrange(4)))
        if not data:
            continue
        peer.receive(port, data)
        assert peer.sent(port) is None, "an answer is in the next instant"
        peer.fmu.updateDiscreteStates()
        answer = peer.sent(port)
        if answer and answer[0] == 1:
            code, length, size = struct.unpack_from("<IIH", answer)
            assert (code, length, answer[10:]) == (1, 10 + size, data), (data, answer)
            corrupt += 1
        peer.fmu.updateDiscreteStates()
        assert peer.sent(port) is None
    assert corrupt > 1500
    assert any("OP Code = " in text for text in peer.messages)


def test_what_a_port_cannot_hold_is_refused(fmus, tmp_path):
    peer = Peer(fmus / "CanNode.fmu", tmp_path / "node")
    peer.fmu.setClock([peer.at["can.Rx_Clock"]], [True])
    with pytest.raises(Exception):
        peer.fmu.setBinary([peer.at["can.Rx_Data"]], [bytes(2049)])
    assert any("`can.Rx_Data`" in text and "at most 2048 bytes" in text for text in peer.messages), peer.messages


def test_the_system_is_valid():
    schema = etree.XMLSchema(file=str(Path(pyssp_standard.__file__).parent / "resources/ssp2/SystemStructureDescription.xsd"))
    schema.assertValid(etree.parse(str(FOLDER / "can.ssd")))


@pytest.mark.parametrize("schedule", ["standard", "jacobi", "gauss-seidel"])
def test_the_system_runs_in_cosim(fmus, tmp_path, schedule):
    """As FMPy above: values pass 222 us and 444 us after they were sent, at the next communication points, and what the last event of a point has
    changed is in that row."""
    signals = ("node_1.y", "node_2.y", "bus.frames")
    options = ("--stop-time", "0.0305", "--step", "1e-4", "--interval", "1e-4", "--schedule", schedule, "--system", FOLDER / "can.ssd")
    rows = recorded(tmp_path / "can.csv", signals, *options, "--fmu-dir", fmus)
    assert len(rows) == 306
    for k, row in enumerate(rows):
        periods, rest = divmod(k, 100)
        frames = 2 * max(periods - 1, 0) + (periods > 0) * ((rest >= 3) + (rest >= 5))
        assert list(row) == [-3.5 if frames >= 1 else 0.0, 1.25 if frames >= 2 else 0.0, frames], (k, row)
