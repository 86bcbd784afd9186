//! Whether the actuators of lift and tilt are as long as their joints' ranges ask for: `machine
//! check` and every run with `--machine` refuse a machine whose `x0` does not fit its strokes.

use hdrm::{GeometryError, Tree};
use machine_file::Machine;

/// Points of a joint's range that are looked at.
const POINTS: u32 = 40;
/// Part of a stroke by which it may be exceeded: dimensions that are drawn at random differ a
/// little.
const SPARE: f64 = 0.02;

/// A line for each actuator whose stroke over the joint's range is not within its limits.
pub fn beyond_strokes(machine: &Machine) -> Result<Vec<String>, GeometryError> {
    let tree = Tree::new(machine)?;
    let (limits, ranges) = (machine.limits.strokes(), machine.limits.zeta());
    let mut found = Vec::new();
    for (k, name) in [(1, "lift"), (2, "tilt")] {
        let [from, to] = ranges[k];
        let stroke = |j: u32| {
            let mut zeta = machine.start.zeta;
            zeta[k] = from + (to - from) * f64::from(j) / f64::from(POINTS);
            tree.configuration(&zeta).strokes[k].x
        };
        let strokes: Vec<_> = (0..=POINTS).map(stroke).collect();
        let least = strokes.iter().copied().fold(f64::INFINITY, f64::min);
        let most = strokes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let [min, max] = limits[k];
        let spare = SPARE * (max - min);
        if least >= min - spare && most <= max + spare {
            continue;
        }
        let (field, x0) = match k {
            1 => ("x0_2", machine.geometry.x0_2),
            _ => ("x0_3", machine.geometry.x0_3),
        };
        let number = k + 1;
        let [shortest, longest] = [x0 + most - max, x0 + least - min];
        let remedy = match shortest <= longest {
            true => format!("it must be within [{shortest:.3}, {longest:.3}] m"),
            false => format!(
                "no length serves: the joint's range needs {:.3} m of stroke, `limits.zeta_min_deg[{number}]` to `zeta_max_deg[{number}]` must be narrower",
                most - least
            ),
        };
        found.push(format!(
            "`geometry.{field}` = {x0}: over the joint's range the stroke of {name} is {least:.3} to {most:.3} m, outside `limits.stroke_{number}` = \
             [{min}, {max}]; {remedy}"
        ));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: the reference lift reaches 0.021 to 0.651 m of 0 to 0.66 m, so x0_2 may be 0.86 −
    /// 0.009 to 0.86 + 0.021.
    #[test]
    fn a_length_that_does_not_fit_the_stroke_is_refused_with_the_range() {
        let mut machine = Machine::reference();
        assert_eq!(beyond_strokes(&machine).expect("closes"), [""; 0]);
        machine.geometry.x0_2 = 1.2;
        let found = beyond_strokes(&machine).expect("closes");
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(
            found[0].starts_with("`geometry.x0_2` = 1.2: ")
                && found[0].ends_with("within [0.851, 0.881] m"),
            "{found:?}"
        );
        machine.geometry.x0_2 = 0.86;
        machine.limits.stroke_3 = [0.0, 0.2];
        let found = beyond_strokes(&machine).expect("closes");
        assert!(found[0].contains("no length serves"), "{found:?}");
    }

    #[test]
    fn shipped_machines_fit() {
        for name in ["sized", "hiab_xs031"] {
            let machine = Machine::preset(name).expect("shipped");
            assert_eq!(beyond_strokes(&machine).expect("closes"), [""; 0], "{name}");
        }
    }
}
