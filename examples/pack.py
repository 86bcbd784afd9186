"""A battery by somebody else, in the place of DcLink.fmu: a source behind a resistance, and the capacitor that the
drives draw from. Its outputs are voltage, charge and current."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

VOLTAGE = (560.0, 700.0)  # V, empty and full
RESISTANCE = 0.3  # Ohm
CAPACITANCE = 15e-3  # F
SUBSTEPS = 20


class Pack(Fmi2Slave):
    description = "Battery and capacitor"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.i_load = [0.0, 0.0, 0.0]
        self.soc, self.capacity, self.i_battery = 0.7, 15.0, 0.0
        self.v_dc = self.source()
        for k in range(3):
            load = Real(f"i_load[{k + 1}]", causality=Fmi2Causality.input, getter=lambda k=k: self.i_load[k], setter=lambda v, k=k: self.draw(k, v))
            self.register_variable(load)
        for name in ("v_dc", "i_battery", "soc"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))
        self.register_variable(Real("capacity", causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))

    def draw(self, k, current):
        self.i_load[k] = current

    def source(self):
        return VOLTAGE[0] + self.soc * (VOLTAGE[1] - VOLTAGE[0])

    def do_step(self, current_time, step_size):
        h = step_size / SUBSTEPS
        for _ in range(SUBSTEPS):
            self.i_battery = (self.source() - self.v_dc) / RESISTANCE
            self.v_dc += h * (self.i_battery - sum(self.i_load)) / CAPACITANCE
            self.soc -= h * self.i_battery / (3600.0 * self.capacity)
        return True
