"""Checks the names and values that a user gives against the variables of a system."""

from __future__ import annotations

import difflib
import math
import numbers
import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hdrm_fmu.errors import BadInput

_SETTABLE = ("parameter", "structuralparameter", "input")
#: Texts that stand for the values of a Boolean.
TRUTHS = {"True": True, "False": False, "true": True, "false": False, "1": True, "0": False}


@dataclass(frozen=True)
class Variable:
    """A variable of a system.

    `name` is `component.variable`; `unit` that of all its values; `items` the items of an enumeration, name and number; `minimum` and `maximum` its
    bounds, where it has some; `driver` the output that a connection takes its value from; `start` its start value as text.
    """

    name: str
    causality: str
    variability: str
    type: str
    unit: str | None
    description: str
    items: dict
    minimum: float | None
    maximum: float | None
    driver: str | None
    start: str | None


def unknown(kind, name, known):
    """The error for an unknown name, which suggests the nearest known ones."""
    known = list(known)
    near = difflib.get_close_matches(str(name), known, n=4, cutoff=0.6)
    if not near:
        short = {k.rsplit(".", 1)[-1]: k for k in known}
        near = [short[s] for s in difflib.get_close_matches(str(name).rsplit(".", 1)[-1], list(short), n=4, cutoff=0.6)]
    listed = " or ".join(f"`{n}`" for n in near)
    return BadInput(f"there is no {kind} `{name}`" + (f"; did you mean {listed}?" if near else ""))


def choice(kind, value, known):
    """`value`, which must be one of `known`."""
    if value not in known:
        raise unknown(kind, value, known) if isinstance(value, str) else BadInput(f"{kind} {value!r}: it must be one of {', '.join(known)}")
    return value


def by_name(settings):
    """`settings` as a dictionary; None is an empty one."""
    if settings is None:
        return {}
    if not isinstance(settings, Mapping):
        raise BadInput(f"settings must be a dictionary of values by name, not {settings!r}")
    return dict(settings)


def positive(name, value, unit="s"):
    """`value` as a finite number of more than 0; None stays None."""
    if value is None:
        return None
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise BadInput(f"{name} = {value!r} must be a number of {unit}") from None
    if not (math.isfinite(number) and number > 0):
        raise BadInput(f"{name} = {value} {unit} must be finite and more than 0")
    return number


def whole(name, value, least):
    """`value` as a whole number of at least `least`."""
    if isinstance(value, (int, float, np.number)) and not isinstance(value, bool) and value == value // 1 and value >= least:
        return int(value)
    raise BadInput(f"{name} = {value!r} must be a whole number of at least {least}")


class Names:
    """The variables of a system by name; the component may be left out if only one has the variable, and an array may be named as a whole.

    `components` may be paths, `system.component`; `inputs` are the system's own inputs, `outputs` its own outputs with the variables that they show.
    """

    def __init__(self, variables, components, inputs, outputs):
        self.all = {v.name: v for v in variables}
        self.inputs, self.outputs = frozenset(inputs), outputs
        self._has_sizes = any(v.causality == "structuralparameter" for v in variables)
        self._short = {}
        self._arrays = {}
        self._short_arrays = {}
        for v in variables:
            owner = max((c for c in components if v.name.startswith(f"{c}.")), key=len)
            short = v.name[len(owner) + 1 :]
            self._short.setdefault(short, []).append(v.name)
            array = re.fullmatch(r"(.*)\[\d+(?:,\d+)*\]", short)
            if array:
                name = f"{owner}.{array[1]}"
                self._arrays.setdefault(name, []).append(v.name)
                self._short_arrays.setdefault(array[1], set()).add(name)

    def one(self, name, kind="variable"):
        """The variable named `name`."""
        name = self.outputs.get(name, name)
        if name in self.all:
            return self.all[name]
        owners = self._short.get(name, [])
        if len(owners) == 1:
            return self.all[owners[0]]
        if owners:
            raise BadInput(f"several components have a {kind} `{name}`: {', '.join(owners)}; name one of them")
        raise unknown(kind, name, [*self.all, *self.inputs, *self.outputs, *(s for s, of in self._short.items() if len(of) == 1)])

    def many(self, name, kind="variable"):
        """The variables that `name` means: one, or the elements of an array."""
        if name in self._arrays:
            return [self.all[n] for n in self._arrays[name]]
        owners = self._short_arrays.get(name, ())
        if len(owners) == 1 and name not in self._short:
            return [self.all[n] for owner in owners for n in self._arrays[owner]]
        return [self.one(name, kind)]

    def sizes(self, settings):
        """What among start values may say how large arrays are: structural parameters, and inputs of a system that has some; by full name."""
        found = {}
        for name, value in settings.items() if self._has_sizes else ():
            if name in self.inputs:
                found[name] = str(value)
            elif name in self.all or len(self._short.get(name, ())) == 1:
                variable = self.one(name)
                if variable.causality == "structuralparameter":
                    found[variable.name] = text(variable, value)
        return found

    def settings(self, values, kind="parameter", allows=False):
        """Checked start values by full name, as the text that the native code takes; with `allows` it decides which may not be finite."""
        checked = {}
        for name, value in values.items():
            if name in self.inputs:
                checked[name] = str(value).lower() if isinstance(value, (bool, np.bool_)) else str(value)
                continue
            variables = self.many(name, kind)
            if len(variables) == 1:
                elements = [value]
            else:
                elements = list(np.ravel(np.asarray(value, dtype=object)))
                if len(elements) != len(variables):
                    raise BadInput(f"`{name}` has {len(variables)} elements, but {len(elements)} values were given")
            for variable, element in zip(variables, elements):
                if variable.causality not in _SETTABLE:
                    raise BadInput(f"`{variable.name}` cannot be set: it is a variable of the kind `{variable.causality}`")
                if variable.name in checked:
                    raise BadInput(f"`{variable.name}` is given twice, once as `{name}`")
                checked[variable.name] = text(variable, element, allows)
        return checked


def text(variable, value, allows=False):
    """The text of a value, which reads back as the same value; refuses a value that the variable cannot have."""
    name = variable.name
    if isinstance(value, np.generic):
        value = value.item()
    if variable.type == "String":
        return str(value)
    if variable.type == "Enumeration":
        if value in variable.items or str(value) in map(str, variable.items.values()):
            return str(value)
        raise unknown(f"item of `{name}`", value, variable.items)
    if variable.type == "Boolean":
        found = value if isinstance(value, bool) else TRUTHS.get(str(value).lower())
        if found is None:
            raise BadInput(f"`{name}` = {value!r} must be true or false")
        return "true" if found else "false"
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise BadInput(f"`{name}` = {value!r} must be a number") from None
    if not (math.isfinite(number) or allows and variable.type == "Real"):
        raise BadInput(f"`{name}` = {number} must be finite")
    for bound, is_beyond, word in ((variable.minimum, number.__lt__, "at least"), (variable.maximum, number.__gt__, "at most")):
        if bound is not None and is_beyond(bound):
            raise BadInput(f"`{name}` = {number:g} must be {word} {bound:g}{f' {variable.unit}' if variable.unit not in (None, '1') else ''}")
    if variable.type == "Real":
        return repr(number)
    if number != int(number) or isinstance(value, str) and not value.lstrip("+-").isdigit():
        raise BadInput(f"`{name}` = {value} must be a whole number")
    return str(int(value) if isinstance(value, numbers.Integral) else int(number))
