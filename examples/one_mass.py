"""A load by somebody else: one mass on a guide with viscous friction, pushed by an actuator against a constant force."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

MASS = 3200.0  # kg
FRICTION = 5e3  # N.s/m
SUBSTEPS = 10


class OneMass(Fmi2Slave):
    description = "One mass on a guide"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.F, self.x, self.x_dot = 0.0, 0.2, 0.0
        self.load, self.F_hold = 15e3, 15e3
        self.register_variable(Real("F", causality=Fmi2Causality.input))
        for name in ("x", "x_dot", "F_hold"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))
        self.register_variable(Real("load", causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))

    def enter_initialization_mode(self):
        self.F_hold = self.load

    def do_step(self, current_time, step_size):
        h = step_size / SUBSTEPS
        for _ in range(SUBSTEPS):  # symplectic Euler
            self.x_dot += h * (self.F - self.load - FRICTION * self.x_dot) / MASS
            self.x += h * self.x_dot
        return True
