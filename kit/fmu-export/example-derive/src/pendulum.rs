use fmu_export::prelude::*;

#[derive(Parameters)] struct Parameters {
    /** Length of the rod */     #[fmu(unit = "m", start = 1.5, min = 1e-3)] length: f64,
    /** Mass at its end */       #[fmu(unit = "kg", start = 2, min = 1e-3)] mass: f64,
    /** Friction of the pivot */ #[fmu(unit = "N.m.s/rad", start = 0.25, min = 0, tunable)] friction: f64,
}
#[derive(Input)] struct Input { /** Torque on the pivot */ #[fmu(unit = "N.m")] torque: f64 }
#[derive(Output)] struct Output {
    /** Kinetic and potential energy */ #[fmu(unit = "J", depends_on(angle, speed), initially_depends_on(length, mass))] energy: f64,
    /** Angular acceleration */         #[fmu(unit = "rad/s2", depends_on(torque, angle, speed))] acceleration: f64,
}
/// A pendulum with a torque on its pivot
#[derive(State)] #[fmu(parameters = Parameters, input = Input, output = Output, model_exchange, experiment(0, 10, 0.01))] struct Pendulum {
    /** Angle from hanging down */ #[fmu(unit = "rad", display_unit = "deg", start = 0.01, rate_depends_on(speed))] angle: f64,
    /** Angular velocity */        #[fmu(unit = "rad/s", display_unit = "deg/s")] speed: f64,
}
impl Ode for Pendulum {
    fn derivative(&self, p: &Parameters, u: &Input, _t: f64, dx: &mut Self) { *dx = Self { angle: self.speed, speed: self.outputs(p, u).acceleration }; }
    fn outputs(&self, &Parameters { length, mass, friction }: &Parameters, u: &Input) -> Output {
        let (inertia, weight) = (mass * length * length, 9.80665 * mass);
        let energy = 0.5 * inertia * self.speed * self.speed + weight * length * (1.0 - self.angle.cos());
        Output { energy, acceleration: (u.torque - friction * self.speed - weight * length * self.angle.sin()) / inertia }
    }
}
export_fmu!(Pendulum);

#[cfg(test)]
mod tests {
    use super::*;

    /// Two states, three parameters and two outputs fit 25 lines, at most 8 of them
    /// ceremony.
    #[test]
    fn the_model_fits_25_lines() {
        let (model, _) = include_str!("pendulum.rs").split_once("#[cfg(test)]").unwrap();
        let lines: Vec<_> = model.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        let is_ceremony = |line: &&&str| **line == "}" || ["use ", "impl ", "export_fmu!"].iter().any(|word| line.starts_with(word));
        let ceremony = lines.iter().filter(is_ceremony).count();
        assert!(lines.len() <= 25, "{} lines", lines.len());
        assert!(ceremony <= 8, "{ceremony} lines of ceremony");
        assert!(lines.iter().all(|line| line.len() <= 150), "lines are too long to be counted as one");
    }

    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<Pendulum>(), [""; 0]);
    }

    /// Oracle: without friction and torque the energy is constant. In a step of dt = 1 ms the method
    /// of order 4 loses the fraction z⁶/72 of it, z = ω dt ≤ 2.6e-3; ω = √(g/l) of small swings is
    /// the largest. 10⁴ steps lose 4e-14, which is below the rounding of 10⁴ steps, 1e-12.
    #[test]
    fn energy_is_kept() {
        let p = Parameters { length: 1.5, mass: 2.0, friction: 0.0 };
        let mut x = Pendulum { angle: 2.5, speed: 0.75 };
        let before = x.outputs(&p, &Input { torque: 0.0 }).energy;
        Model::step(&mut x, &p, &InputPolynomial::held(Input { torque: 0.0 }), &(), 0.0, 10.0).unwrap();
        let after = x.outputs(&p, &Input { torque: 0.0 }).energy;
        assert!((after / before - 1.0).abs() < 1e-12, "{before} {after}");
        assert!((x.angle - 2.5).abs() > 0.1, "{}", x.angle);
    }
}
