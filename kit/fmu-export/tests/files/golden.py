"""Monotone cubics by SciPy's PchipInterpolator: the numbers in main.rs.

    python golden.py

They change if the tables here change, and by some units of the last digit with another release of SciPy (1.17.1).
"""

import numpy as np
from scipy.interpolate import PchipInterpolator

X = [-1.0, 0.25, 1.0, 3.0, 3.5, 7.0]
Y = [0.5, 0.75, 3.0, 3.0, 2.5, 4.0]
PLACES = [-1.0, -0.9, 0.0, 0.25, 0.8, 1.7, 3.2, 3.5, 4.0, 6.9, 7.0]
print("CURVE", [float(y) for y in PchipInterpolator(X, Y)(PLACES)])

Z = np.array([[(1 + i) ** 1.5 * (2 - j) + 0.25 * j * j for j in range(4)] for i in range(5)])
X, Y = [0.0, 1.0, 2.5, 3.0, 5.0], [-2.0, -1.0, 1.5, 2.0]
print("Z", Z.tolist())
along_y = PchipInterpolator(Y, Z, axis=1)
for x, y in [(0.3, -1.7), (1.0, 0.0), (2.7, 1.9), (4.9, 1.5), (1.3, 1.2)]:
    print("MAP", x, y, float(PchipInterpolator(X, along_y(y))(x)))
