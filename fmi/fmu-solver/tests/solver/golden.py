"""Stiff problems solved by SciPy: the numbers in stiff.rs. Those of the literature by Radau IIA of order 5 at a relative tolerance of
1e-13; then what its BDF needs for one communication step of the rod, with the same sparsity.

    python golden.py

They change if a problem here changes, and by some units of the eleventh digit with another release of SciPy (1.17.1).
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.sparse import diags_array


def robertson(_, x):
    a, b, c = 0.04 * x[0], 1e4 * x[1] * x[2], 3e7 * x[1] ** 2
    return [b - a, a - b - c, c]


def van_der_pol(_, x, mu=1e3):
    return [x[1], mu * ((1 - x[0] ** 2) * x[1]) - x[0]]


for name, f, start, times in [
    ("ROBERTSON", robertson, [1.0, 0.0, 0.0], [0.4, 40.0, 4000.0]),
    ("VAN_DER_POL", van_der_pol, [2.0, 0.0], [400.0, 800.0, 1000.0]),
]:
    done = solve_ivp(f, (0.0, times[-1]), start, method="Radau", rtol=1e-13, atol=1e-18, t_eval=times)
    for t, x in zip(times, done.y.T):
        print(name, t, [float(value) for value in x])


def conduction(_, x):
    n = len(x)
    flow = n * n * np.diff(x)
    return np.append(flow, 0.0) - np.append(0.0, flow)


def waves(n, t):
    """Closed form: see stiff.rs."""
    half = 0.5 * np.pi * np.array([[1.0], [4.0]]) / n
    modes = np.cos(half * (2 * np.arange(n) + 1)) * np.exp(-4.0 * n * n * np.sin(half) ** 2 * t)
    return 2.0 + modes[0] + 0.5 * modes[1]


evaluations = 0


def counted(t, x):
    global evaluations
    evaluations += 1
    return conduction(t, x) if x.ndim == 1 else np.stack([conduction(t, column) for column in x.T], axis=1)


for n in [64, 1000]:
    pattern = diags_array([np.ones(n - 1), np.ones(n), np.ones(n - 1)], offsets=[-1, 0, 1])
    for tolerance in [1e-4, 1e-6, 1e-8]:
        evaluations = 0
        done = solve_ivp(counted, (0.0, 0.1), waves(n, 0.0), method="BDF", rtol=tolerance, atol=tolerance, jac_sparsity=pattern)
        error = np.max(np.abs(done.y[:, -1] - waves(n, 0.1)))
        print("BDF", n, tolerance, "right-hand sides", done.nfev, "Jacobians", done.njev, "of them each by differences; error", error)
