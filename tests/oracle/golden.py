"""Golden files as text that shows in a diff which state changed: one state (case, row, section of a machine) a line.

Used by the scripts here that write nested JSON. `python tests/oracle/golden.py FILE.json` writes a file anew in this form; values do not change.
"""

import json
import sys
from pathlib import Path

#: A value whose text is shorter stands on one line, unless it holds a list of states.
LONGEST_STATE = 3000


def write(path, value):
    path.write_text(text(value) + "\n")


def text(value, indent=""):
    """JSON of `value`, of which lists of states and what is around them are opened, one item a line."""
    whole = json.dumps(value, default=lambda array: array.tolist())
    if len(whole) < LONGEST_STATE and not holds_states(value):
        return whole
    inner = indent + " "
    if isinstance(value, dict):
        items, ends = [f"{json.dumps(key)}: {text(v, inner)}" for key, v in value.items()], "{}"
    else:
        items, ends = [text(v, inner) for v in value], "[]"
    return f"{ends[0]}\n{inner}" + f",\n{inner}".join(items) + f"\n{indent}{ends[1]}"


def holds_states(value):
    """Whether there is a list of objects in a value."""
    if isinstance(value, dict):
        return any(map(holds_states, value.values()))
    return isinstance(value, (list, tuple)) and any(isinstance(v, dict) for v in value)


if __name__ == "__main__":
    for name in sys.argv[1:]:
        write(Path(name), json.loads(Path(name).read_text()))
