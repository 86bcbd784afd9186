"""Reference outputs of the shipped surrogate network by NumPy; writes surrogate_inference.json beside this file.

    python tests/oracle/surrogate_inference.py        (versions: tests/oracle/requirements.txt)

Plain matrix products and the library's tanh, then the guards of the Rust documentation written out anew.
The golden file changes when parameters/surrogate.json is replaced, never to follow the Rust code.
"""

import json
import pathlib

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
FILE = json.loads((HERE.parent.parent / "parameters" / "surrogate.json").read_text())
LAYERS = [(np.array(l["weights"]), np.array(l["bias"])) for l in FILE["layers"]]
RANGES = FILE["ranges"]


def scale(name, x):
    r = RANGES[name]
    return 2 * (np.clip(x, r["min"], r["max"]) - r["min"]) / (r["max"] - r["min"]) - 1


def unscale(name, y):
    r = RANGES[name]
    return (y + 1) * (r["max"] - r["min"]) / 2 + r["min"]


def network(tau, w):
    a = np.array([scale("tau_e", tau), scale("w_m", w)])
    for matrix, bias in LAYERS[:-1]:
        a = np.tanh(matrix @ a + bias)
    matrix, bias = LAYERS[-1]
    force, speed = matrix @ a + bias
    return np.array([unscale("F_ext", force), unscale("x_dot", speed)])


def guarded(tau, w):
    s = np.tanh(w / 2)
    return (1 + s) / 2 * network(tau, abs(w)) - (1 - s) / 2 * network(-tau, abs(w))


rng = np.random.default_rng(5)
points = np.column_stack([rng.uniform(-60, 60, 300), rng.uniform(-250, 250, 300)])
points[:100, 1] /= 40  # around standstill
rows = [[tau, w, *guarded(tau, w)] for tau, w in points]
text = json.dumps({"columns": ["tau_e", "w_m", "F", "x_dot"], "rows": [list(map(float, r)) for r in rows]})
(HERE / "surrogate_inference.json").write_text(text + "\n")
