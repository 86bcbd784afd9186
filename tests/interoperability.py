"""What `test_importers.py` shows of other people's importers and checkers, as data, and the tables of docs/fmus/interoperability.md made of it.

    python tests/interoperability.py     write the tables; a test compares them
"""

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/fmus/interoperability.md"
MODELS = ("Emla", "Hdrm", "Controller")
PACKAGE = "Manipulator.ssp"
FMI_SIM = "0.7.0"
PINNED = dict(re.findall(r"^([\w-]+)==(\S+)$", Path(__file__).with_name("requirements.txt").read_text(), re.MULTILINE))


@dataclass(frozen=True)
class Coupled:
    """What an importer's coupled run equals: a schedule of our masters, to tolerances in A of i_q (Emla), m of x (Hdrm) and V of v_q
    (Controller). `after_set`: it reads outputs after it has set the inputs of the same communication point."""

    schedule: str
    tolerances: tuple = (0.0, 0.0, 0.0)
    why: str = ""
    after_set: bool = False


@dataclass(frozen=True)
class Importer:
    """An importer: its name in the table, by how much it differs alone (of each output's peak), what its coupled run equals."""

    title: str
    alone: float
    coupled: Coupled | None


# Importers that add up times or interpolate inputs give times or inputs that are rounded otherwise; the stiff nut-rod spring and the
# controller's gains make that visible.
ROUNDING, COUPLED_ROUNDING = 1e-12, (1e-9, 1e-13, 1e-9)
TOOLBOX = f"fmu-manipulation-toolbox {PINNED['fmu-manipulation-toolbox']}"
#: By the class in `importers` or `containers`.
IMPORTERS = {
    "FMPy": Importer(f"FMPy {PINNED['FMPy']}", ROUNDING, Coupled("gauss-seidel", why="with the master `tests/fmpy_master.py`")),
    "FMPyContainer": Importer(f"FMPy {PINNED['FMPy']}, container", 0.0, Coupled("jacobi")),
    "Ecos": Importer(f"ecospy {PINNED['ecospy']}", 0.0, Coupled("standard", COUPLED_ROUNDING, after_set=True)),
    "Libcosim": Importer(f"libcosimpy {PINNED['libcosimpy']}", ROUNDING, Coupled("standard", COUPLED_ROUNDING)),
    "FmiSim": Importer(f"fmi-sim {FMI_SIM}", 0.0, None),
    "ToolboxParallel": Importer(f"{TOOLBOX}, container, parallel", 0.0, Coupled("standard")),
    "ToolboxSequential": Importer(
        f"{TOOLBOX}, container, sequential", 0.0,
        Coupled("gauss-seidel", (0.1, 1e-4, 0.1), "manipulator first: forces come one step late"),
    ),
}  # fmt: skip
#: Importers that read FMI 3.0, and by how much they differ with `fmi3/Emla.fmu`, whose variables are scalars, which all of them know.
IMPORTERS_3 = {"FMPy": ROUNDING, "FMPyContainer": 0.0, "Ecos": 0.0, "Fmuloader": 0.0, "ToolboxParallel": 0.0, "ToolboxSequential": 0.0}
#: Title and what it says about the package.
CHECKERS = (
    (f"FMPy {PINNED['FMPy']}, `validate_fmu`, `read_ssd` with the schemas", "none"),
    (f"{TOOLBOX}, `fmutool -check`, `fmucontainer`", "loop of links at initialization: see below"),
    (f"pyssp_standard {PINNED['pyssp_standard']}, readers of FMU, SSP and SSV, schemas of SSP", "none"),
)


def cells(importer):
    alone = f"{importer.alone:g} of each output's peak" if importer.alone else "the last bit"
    coupled = importer.coupled
    if coupled is None:
        return importer.title, alone, "cannot", "-"
    units = ("A of i_q", "m of x", "V of v_q")
    numbers = ", ".join(f"{tolerance:g} {unit}" for tolerance, unit in zip(coupled.tolerances, units))
    agrees = numbers if any(coupled.tolerances) else "the last bit"
    return importer.title, alone, f"as `{coupled.schedule}`", agrees + (f" ({coupled.why})" if coupled.why else "")


def tables():
    lines = ["| importer | alone agrees to | coupled | coupled agrees to |", "|---|---|---|---|"]
    lines += [f"| {' | '.join(cells(importer))} |" for importer in IMPORTERS.values()]
    lines += ["", "| checker | complaints about the FMUs | complaints about the package |", "|---|---|---|"]
    lines += [f"| {title} | none | {complaint} |" for title, complaint in CHECKERS]
    return "\n".join(lines)


def page():
    """The page's text with the tables as they should be."""
    before, start, rest = PAGE.read_text().partition("<!-- table -->\n")
    _, end, after = rest.partition("\n<!-- end of table -->")
    assert start and end, f"{PAGE} has lost its marks"
    return before + start + tables() + end + after


if __name__ == "__main__":
    PAGE.write_text(page())
