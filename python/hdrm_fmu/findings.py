"""What is found on a run or a machine, as data: the class `Finding`."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray

#: Attribute of a run with its findings as JSON.
ATTRIBUTE = "findings_json"


@dataclass(frozen=True)
class Finding:
    """A finding: `severity` is `bad` if it spoils the result, else `note`; `text` is what the programs print; `subject` is the variable, the
    component or the field of a machine file that it is about, empty where the text names none."""

    severity: str
    text: str
    subject: str

    def __str__(self) -> str:
        return ("! " if self.severity == "bad" else "- ") + self.text


def found(is_bad: bool, text: str, components: Iterable[str] = ()) -> Finding:
    """The finding of a text; its subject is the first component of a system that it names, with the variable, else what it has in backquotes."""
    names = "|".join(map(re.escape, sorted(components, key=len, reverse=True)))
    match = re.search(rf"(?<![\w.])(?:{names})(?:\.\w+(?:\[[\d,]+\])?)*(?!\w)", text) if names else None
    quoted = re.search("`([^`]+)`", text)
    return Finding("bad" if is_bad else "note", text, match[0] if match else quoted[1] if quoted else "")


def as_text(findings: Iterable[Finding]) -> str:
    """The lines that the programs print."""
    return "\n".join(map(str, findings))


def as_json(findings: Iterable[Finding]) -> str:
    """As an attribute of a run, which any file format takes."""
    return json.dumps([asdict(finding) for finding in findings])


def findings(run: xarray.Dataset) -> list[Finding]:
    """What was found on a run, in the order of the program's print: `[f.subject for f in findings(run) if f.severity == "bad"]`."""
    return [Finding(**finding) for finding in json.loads(run.attrs[ATTRIBUTE])]
