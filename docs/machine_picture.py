"""Draws docs/machine.svg, the moving machine of the README, from a recorded run.

    cargo xtask hdrm-fmu -- run --csv motion.csv --signals "hdrm.zeta[*]" --interval 0.25
    python docs/machine_picture.py motion.csv        (versions: tests/oracle/requirements.txt)
"""

import csv
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests/oracle"))

from mechanism import BODIES, point, reference_machine, solve  # noqa: E402

#: Pixels per metre, and where the foot of the column stands.
SCALE, ORIGIN = 98.0, (90.0, 318.0)
#: Colour and width of each part, from back to front; a part is a line through joints.
PARTS = {
    "column": (["base", "O"], "#5b6570", 26),
    "lift rod": (["D2", "pin"], "#c9ced3", 7),
    "lift cylinder": (["foot", "D2"], "#2f6db3", 13),
    "boom": (["O", "pin", "B"], "#e2a43b", 20),
    "tilt rod": (["D3", "D"], "#c9ced3", 6),
    "tilt cylinder": (["E", "D3"], "#2f6db3", 12),
    "linkage": (["A", "D", "C"], "#5b6570", 6),
    "arm": (["C", "B", "A4"], "#d98c2b", 17),
    "wrist": (["A4", "C4", "D4"], "#5b6570", 13),
    "tool": (["D4", "tip"], "#b03a2e", 8),
}


def joints(machine, zeta):
    """World positions of the joints by name."""
    poses, tip, _ = solve(machine, zeta)
    pose = dict(zip(BODIES, poses))
    g = machine["geometry"]
    at = {"base": np.zeros(3), "O": pose["A2"][:3, 3], "pin": point(pose["A2"], [g["L1_2"]]), "foot": pose["C2"][:3, 3]}
    at |= {"B": pose["A3"][:3, 3], "A": pose["RK"][:3, 3], "D": point(pose["RK"], [g["d4"]]), "C": pose["CP"][:3, 3], "E": pose["C3"][:3, 3]}
    return {name: np.asarray(p) for name, p in at.items()} | {n: np.asarray(pose[n][:3, 3]) for n in ("D2", "D3", "A4", "C4", "D4")} | {"tip": np.asarray(tip[:3, 3])}


def seen(p):
    """Where a point of the world is in the picture: x to the right, y up, z towards the viewer, obliquely."""
    return ORIGIN[0] + SCALE * (p[0] - 0.35 * p[2]), ORIGIN[1] - SCALE * (p[1] - 0.3 * p[2])


def line(at, names):
    return " ".join(f"{x:.0f},{y:.0f}" for x, y in (seen(at[name]) for name in names))


def main():
    with open(sys.argv[1]) as file:
        rows = [[float(v) for v in row] for row in list(csv.reader(file))[1:]]
    machine = reference_machine()
    frames = [joints(machine, np.array(row[1:7])) for row in rows]
    duration = rows[-1][0] / 3  # three times as fast as simulated
    parts = [f'<polyline class="path" points="{" ".join(line(at, ["tip"]) for at in frames)}"/>']
    for name, (through, colour, width) in PARTS.items():
        moving = ";".join(line(at, through) for at in frames)
        parts.append(
            f'<polyline stroke="{colour}" stroke-width="{width}" points="{line(frames[0], through)}"><title>{name}</title>'
            f'<animate attributeName="points" dur="{duration:g}s" repeatCount="indefinite" values="{moving}"/></polyline>'
        )
    text = f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 480 340" role="img" aria-label="The manipulator moves its tip along the cubic trajectory">
<style>polyline {{ fill: none; stroke-linecap: round; stroke-linejoin: round }} .path {{ stroke: #b03a2e; stroke-width: 1.5; stroke-dasharray: 4 3 }}</style>
<rect width="480" height="340" fill="#f7f8f9"/>
<line x1="20" y1="{ORIGIN[1] + 12}" x2="460" y2="{ORIGIN[1] + 12}" stroke="#9aa3ab" stroke-width="2"/>
{chr(10).join(parts)}
</svg>
"""
    (ROOT / "docs/machine.svg").write_text(text)


if __name__ == "__main__":
    main()
