"""Levenberg-Marquardt paths of two small networks by NumPy; writes surrogate_lm.json beside this file.

    python tests/oracle/surrogate_lm.py        (versions: tests/oracle/requirements.txt)

Independent of the Rust code: the Jacobian by complex steps (exact to rounding) instead of
backpropagation, the plain (J'J/R + mu I) solved by LU, whichever form the Rust code takes. Rules of MATLAB's
trainlm: mu starts at 1e-3, x0.1 after a step that lowers the mean squared error, x10 otherwise.
The golden file changes only with this script.
"""

import json
import pathlib

import numpy as np

WIDTHS = [2, 5, 4, 2]
ITERATIONS = 8


def outputs(weights, inputs):
    """Network outputs, one row per sample; layer by layer: matrix row by row, then bias."""
    a, start = inputs.T, 0
    for k, (n, m) in enumerate(zip(WIDTHS, WIDTHS[1:])):
        matrix = weights[start : start + n * m].reshape(m, n)
        bias = weights[start + n * m : start + (n + 1) * m]
        start += (n + 1) * m
        a = matrix @ a + bias[:, None]
        if k + 2 < len(WIDTHS):
            a = np.tanh(a)
    return a.T


def jacobian(weights, inputs):
    step = 1e-30
    columns = []
    for k in range(len(weights)):
        w = weights.astype(complex)
        w[k] += 1j * step
        columns.append(outputs(w, inputs).imag.ravel() / step)
    return np.array(columns).T


def path(samples, seed):
    rng = np.random.default_rng(seed)
    inputs = rng.uniform(-1, 1, (samples, 2))
    x, y = inputs.T
    targets = np.column_stack([np.sin(2 * x) * y - 0.3 * x, 0.7 * y + 0.4 * x * x - 0.2])
    count = sum((n + 1) * m for n, m in zip(WIDTHS, WIDTHS[1:]))
    weights = rng.uniform(-0.9, 0.9, count)
    mu, record = 1e-3, []
    first, jacobian_first = weights, jacobian(weights, inputs)
    for _ in range(ITERATIONS):
        e = (outputs(weights, inputs) - targets).ravel()
        j = jacobian(weights, inputs)
        while True:
            normal = j.T @ j / len(e) + mu * np.eye(count)
            trial = weights - np.linalg.solve(normal, j.T @ e / len(e))
            lower = np.mean((outputs(trial, inputs) - targets) ** 2) < np.mean(e**2)
            mu *= 0.1 if lower else 10
            if lower:
                break
        weights = trial
        record.append({"weights": list(weights), "mu": mu, "mse": np.mean((outputs(weights, inputs) - targets) ** 2)})
    return {
        "inputs": inputs.tolist(),
        "targets": targets.tolist(),
        "first_weights": list(first),
        "jacobian_rows": {"0": list(jacobian_first[0]), "7": list(jacobian_first[7])},
        "path": record,
    }


# 45 weights: 60 residual pairs make J'J the smaller matrix, 15 make J J' the smaller one.
cases = [path(60, 11), path(15, 12)]
here = pathlib.Path(__file__).resolve().parent
(here / "surrogate_lm.json").write_text(json.dumps({"widths": WIDTHS, "cases": cases}) + "\n")
for case in cases:
    print([f"{step['mu']:.0e} {step['mse']:.2e}" for step in case["path"]])
