"""Stiff problems solved by SciPy (Radau IIA of order 5 at a relative tolerance of 1e-13): the numbers in stiff.rs.

    python golden.py

They change if a problem here changes, and by some units of the eleventh digit with another release of SciPy (1.17.1).
"""

from scipy.integrate import solve_ivp


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
