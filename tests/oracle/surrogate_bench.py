"""One Levenberg-Marquardt iteration of the full network, Rust and NumPy/SciPy (OpenBLAS) side by side.

    cargo build --release -p surrogate --example lm_iteration
    python tests/oracle/surrogate_bench.py target/release/examples/lm_iteration [ROWS [ROUNDS]]

Both take one step with one Cholesky factorisation: Jacobian by backpropagation, normal matrix, factor, solve,
error at the new weights. NumPy forms J and the smaller of J'J and JJ' (numpy calls syrk), SciPy factors it in
place. The second NumPy line is given our trick, too: JJ' summed over layers without ever forming J. Runs alternate,
so that other load on the machine hits all alike; medians are printed.
"""

import statistics
import subprocess
import sys
import time

import numpy as np
from scipy.linalg import cho_factor, cho_solve

WIDTHS = [2, 64, 48, 32, 16, 8, 2]


def layers(weights):
    start = 0
    for n, m in zip(WIDTHS, WIDTHS[1:]):
        yield weights[start : start + n * m].reshape(m, n), weights[start + n * m : start + (n + 1) * m]
        start += (n + 1) * m


def activations(weights, inputs):
    a = [inputs]
    for k, (matrix, bias) in enumerate(layers(weights)):
        z = a[-1] @ matrix.T + bias
        a.append(np.tanh(z) if k + 2 < len(WIDTHS) else z)
    return a


def deltas(weights, a):
    """For each output: derivative by the weighted sums of every layer."""
    matrices = [matrix for matrix, _ in layers(weights)]
    result = []
    for o in range(2):
        d = [np.tile(np.eye(2)[o], (len(a[0]), 1))]
        for l in range(len(matrices) - 1, 0, -1):
            d.insert(0, (d[0] @ matrices[l]) * (1 - a[l] ** 2))
        result.append(d)
    return result


def jacobian(a, d):
    blocks = []
    for o in range(2):
        parts = []
        for l in range(len(WIDTHS) - 1):
            parts += [(d[o][l][:, :, None] * a[l][:, None, :]).reshape(len(a[0]), -1), d[o][l]]
        blocks.append(np.hstack(parts))
    return np.vstack(blocks)


def kernel(a, d):
    n = len(a[0])
    k = np.zeros((2 * n, 2 * n))
    for l in range(len(WIDTHS) - 1):
        x = a[l] @ a[l].T + 1
        for o in range(2):
            for p in range(o + 1):
                k[o * n : (o + 1) * n, p * n : (p + 1) * n] += x * (d[o][l] @ d[p][l].T)
    return k


def iteration(weights, inputs, targets, mu, trick):
    a = activations(weights, inputs)
    e = (a[-1] - targets).T.ravel()
    d = deltas(weights, a)
    j = jacobian(a, d)
    if trick or len(e) < len(weights):
        normal = kernel(a, d) if trick else j @ j.T
        normal[np.diag_indices_from(normal)] += mu * len(e)
        factor = cho_factor(normal, lower=True, overwrite_a=True, check_finite=False)
        step = j.T @ cho_solve(factor, e, check_finite=False)
    else:
        normal = j.T @ j
        normal[np.diag_indices_from(normal)] += mu * len(e)
        factor = cho_factor(normal, lower=True, overwrite_a=True, check_finite=False)
        step = cho_solve(factor, j.T @ e, check_finite=False)
    return np.mean((activations(weights - step, inputs)[-1] - targets) ** 2)


def main():
    program, rows = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 3000
    rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    k = np.arange(rows)
    inputs = np.column_stack([np.sin(1.7 * k), np.cos(0.9 * k + 0.3)])
    x, y = inputs.T
    targets = np.column_stack([0.6 * x * y + 0.1, 0.5 * np.sin(x - y)])
    rng = np.random.default_rng(1)
    count = sum((n + 1) * m for n, m in zip(WIDTHS, WIDTHS[1:]))
    weights = rng.uniform(-0.3, 0.3, count)
    times = {"Rust": [], "NumPy/SciPy, plain": [], "NumPy/SciPy, with the layer-wise J J'": []}
    for _ in range(rounds):
        run = subprocess.run([program, str(rows), "1"], capture_output=True, text=True, check=True)
        times["Rust"].append(float(run.stdout))
        for name, trick in list(zip(times, [None, False, True]))[1:]:
            clock = time.perf_counter()
            iteration(weights, inputs, targets, 1.0, trick)
            times[name].append(time.perf_counter() - clock)
    rust = statistics.median(times["Rust"])
    print(f"one LM iteration, {count} weights, {rows} rows, median of {rounds}")
    for name, seconds in times.items():
        median = statistics.median(seconds)
        print(f"{name:40s} {median:7.3f} s   Rust takes {rust / median:.2f} of it")


main()
