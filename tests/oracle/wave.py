"""Signals of the trajectories: sums of sines, with their derivatives."""

import math


class Wave:
    """offset + sum of amplitude * sin(2 pi frequency t + phase)."""

    def __init__(self, offset, *terms):
        self.offset, self.terms = offset, terms

    def __call__(self, t, order=0):
        value = self.offset if order == 0 else 0.0
        for amplitude, frequency, phase in self.terms:
            w = 2 * math.pi * frequency
            value += amplitude * w**order * math.sin(w * t + phase + order * math.pi / 2)
        return value

    def json(self):
        return {"offset": self.offset, "terms": [list(term) for term in self.terms]}
