"""The manipulator as a MuJoCo model, rigid or bending: the MJCF file that `hdrm-fmu machine export` writes for a machine file, with other
masses and gravity, and beams cut by hinges.

Both closed loops are MuJoCo `connect` constraints, so the geometry is a little soft where Hdrm.fmu is exact. Joint coordinates are joint
angles and strokes. MuJoCo's world has z up: `UP` turns vectors of Hdrm's axes, y up, to it.
"""

import json
import os
import shutil
import subprocess
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from math import sqrt
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

SUBSTEP = 2.5e-4  # s
UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
HERE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class Flexure:
    """A virtual hinge that cuts a beam in two: body, point and axis in the body's frame, spring N.m/rad, damper N.m.s/rad."""

    body: str
    point: tuple
    axis: str
    stiffness: float
    damping: float

    @property
    def name(self):
        return f"flexure_{self.body}"


def program():
    """The program `hdrm-fmu`: named by HDRM_FMU, as build.py noted beside this file, of this repository's build, or on the path."""
    noted = HERE / "hdrm-fmu.txt"
    places = [os.environ.get("HDRM_FMU"), noted.read_text() if noted.exists() else None]
    places += [HERE.parent / "target" / kind / "hdrm-fmu" for kind in ("release", "debug")] + [shutil.which("hdrm-fmu")]
    found = next((place for place in places if place and Path(place).is_file()), None)
    if not found:
        raise FileNotFoundError("the program hdrm-fmu, which writes the machine for MuJoCo, is not found: name it in the variable HDRM_FMU")
    return str(found)


def exported(machine):
    """The machine's MJCF file."""
    with TemporaryDirectory() as folder:
        file, made = Path(folder, "machine.json"), Path(folder, "machine.xml")
        file.write_text(json.dumps(machine))
        done = subprocess.run([program(), "machine", "export", str(file), "--mjcf", str(made)], capture_output=True, text=True)
        if done.returncode:
            raise ValueError(done.stderr.strip())
        return made.read_text()


def text(values):
    return " ".join(f"{v:.17g}" for v in values)


def numbers(element, name):
    return np.array(element.get(name).split(), dtype=float)


def inertial(mass, com, inertia):
    entries = [inertia[i] for i in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    return ET.Element("inertial", pos=text(com), mass=f"{mass:.17g}", fullinertia=text(entries))


def cut(mass, com, inertia, point):
    """A body in two along its longest axis, at a point of it: mass, centre and inertia of the part nearer to the frame's origin, then
    of the other. The body is taken for the uniform box of its inertia, so both parts together have exactly its mass properties."""
    moments, axes = np.linalg.eigh(inertia)
    square = 6 * (np.sum(moments) - 2 * moments) / mass  # of the box's edges: I_x = m (y² + z²)/12
    long = np.argmax(square)
    length, along = sqrt(square[long]), axes[:, long]
    if along @ com < 0:
        along = -along
    share = 0.5 + along @ (np.asarray(point) - com) / length
    if not 0 < share < 1:
        raise ValueError(f"the flexure at {point} must lie within the beam of length {length:.3f} m around {com}")
    parts = []
    for part, offset in ((share, (share - 1) / 2), (1 - share, share / 2)):
        edges = np.where(np.arange(3) == long, square * part**2, square)
        inner = axes @ np.diag(part * mass * (np.sum(edges) - edges) / 12) @ axes.T
        parts.append((part * mass, com + offset * length * along, inner))
    return parts


def mjcf(machine, scale=1.0, flexures=(), gravity=None):
    """The model in the machine's start pose; `gravity` in Hdrm's axes, m/s². All but the coupler hangs behind a flexure."""
    root = ET.fromstring(exported(machine))
    if gravity is not None:
        root.find("option").set("gravity", text(UP @ gravity))
    for own in root.iter("inertial"):
        for name in ("mass", "fullinertia"):
            own.set(name, text(scale * numbers(own, name)))
    for flexure in flexures:
        body = root.find(f".//body[@name='{flexure.body}']")
        whole = body.find("inertial")
        xx, yy, zz, xy, xz, yz = numbers(whole, "fullinertia")
        matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        near, far = cut(float(whole.get("mass")), numbers(whole, "pos"), matrix, flexure.point)
        body.remove(whole)
        body.insert(1, inertial(*near))
        outer = ET.Element("body", name=f"{flexure.body}_far")
        spring = {"stiffness": f"{flexure.stiffness:.17g}", "damping": f"{flexure.damping:.17g}"}
        outer.append(ET.Element("joint", name=flexure.name, pos=text(flexure.point), axis=flexure.axis, **spring))
        outer.append(inertial(*far))
        for child in [child for child in body.findall("body") if child.get("name") != "CP"]:
            body.remove(child)
            outer.append(child)
        body.append(outer)
    root.remove(root.find("keyframe"))  # it knows nothing of the flexures
    return ET.tostring(root, encoding="unicode")
