//! Reads angles of a machine file in either unit, for `source`: `beta1` in rad is `beta1_deg` in
//! degrees, and `zeta_min_deg` in degrees is `zeta_min` in rad. What the file's other spelling says
//! is written under the name that [`crate::Machine`] has.

use crate::check::Findings;
use serde_json::Value;

/// Sections and names of the angles: as [`crate::Machine`] has them, and in the other unit.
pub(crate) const ANGLES: [(&str, &str, &str); 5] = [
    ("geometry", "beta1", "beta1_deg"),
    ("geometry", "beta2", "beta2_deg"),
    ("limits", "zeta_min_deg", "zeta_min"),
    ("limits", "zeta_max_deg", "zeta_max"),
    ("start", "zeta", "zeta_deg"),
];

/// Replaces the other spelling of each angle; both in one file are refused.
pub(crate) fn unify(file: &mut Value, found: &mut Findings) {
    for (section, own, other) in ANGLES {
        let Some(Value::Object(fields)) = file.get_mut(section) else {
            continue;
        };
        let Some(mut value) = fields.remove(other) else {
            continue;
        };
        if fields.contains_key(own) {
            let problem = format!("and `{section}.{own}` say the same: give one of both");
            found.add(format_args!("{section}.{other}"), problem);
            continue;
        }
        let is_own_in_degrees = own.ends_with("_deg");
        let convert = |angle: &mut Value| {
            let converted = match angle.as_f64() {
                Some(rad) if is_own_in_degrees => rad.to_degrees(),
                Some(degrees) => degrees.to_radians(),
                None => return,
            };
            *angle = converted.into();
        };
        match &mut value {
            Value::Array(elements) => elements.iter_mut().for_each(convert),
            one => convert(one),
        }
        fields.insert(own.to_owned(), value);
    }
}

#[cfg(test)]
mod tests {
    use crate::Machine;
    use serde_json::json;

    /// Every angle in the unit in which the reference machine's file does not have it.
    #[test]
    fn angles_are_read_in_both_units() {
        let reference = Machine::reference();
        let text = json!({"extends": "reference",
            "geometry": {"beta1_deg": 15.0, "beta2_deg": 10.0},
            "limits": {"zeta_min": [-0.9, -0.05, -2.1, -3.0, -1.8, -3.0], "zeta_max": [0.9, 1.1, -0.4, 3.0, -0.2, 3.0]},
            "start": {"zeta_deg": [0, 40, -80, 0, -50, 0]}});
        let machine = Machine::from_json(&text.to_string()).expect("valid");
        assert_eq!(machine.geometry.beta1, reference.geometry.beta1);
        assert_eq!(machine.geometry.beta2, reference.geometry.beta2);
        assert_eq!(machine.start.zeta, reference.start.zeta);
        let [min, max] = machine.limits.zeta()[2];
        assert!((min + 2.1).abs() < 1e-15 && (max + 0.4).abs() < 1e-15);
    }

    #[test]
    fn an_angle_that_is_given_twice_is_refused() {
        let text = json!({"extends": "reference", "start": {"zeta_deg": [0, 40, -80, 0, -50, 0], "zeta": [0, 0.7, -1.4, 0, -0.9, 0]}});
        let error = Machine::from_json(&text.to_string()).expect_err("refused");
        assert_eq!(
            error.to_string(),
            "`start.zeta_deg` and `start.zeta` say the same: give one of both"
        );
    }

    /// What cannot be built, and degrees where radians are meant: refused with the allowed range.
    #[test]
    fn impossible_dimensions_are_refused_with_the_range() {
        for (own, expected) in [
            (
                json!({"geometry": {"lc_2": 0.9}}),
                "`geometry.lc_2` = 0.9 must be at most `x0_2` = 0.86",
            ),
            (
                json!({"geometry": {"lc_3": 0.71}}),
                "`geometry.lc_3` = 0.71 must be at most `x0_3` = 0.7",
            ),
            (
                json!({"geometry": {"x1_mid": 0.9}}),
                "`geometry.x1_mid` = 0.9 must be within the stroke",
            ),
            (
                json!({"geometry": {"beta1": 15}}),
                "`geometry.beta1` = 15 must be within ±π rad; in degrees it is `beta1_deg`",
            ),
            (
                json!({"geometry": {"beta2": -10}}),
                "`geometry.beta2` = -10 must be within ±π rad",
            ),
            (
                json!({"start": {"zeta": [0, 40, -80, 0, -50, 0]}}),
                "`start.zeta[2]` = 40 must be within the joint limits",
            ),
            (
                json!({"limits": {"zeta_min_deg": [-180, -5, -125, -180, -110, -180]}}),
                "`limits.zeta_min_deg[1]` = -180 must be at least -57.3: the slew actuator's stroke",
            ),
            (
                json!({"limits": {"zeta_max_deg": [180, 65, -20, 180, -10, 180]}}),
                "`limits.zeta_max_deg[1]` = 180 must be at most 57.3: the slew actuator's stroke",
            ),
        ] {
            let mut own = own;
            own["extends"] = "reference".into();
            let error = Machine::from_json(&own.to_string()).expect_err("refused");
            assert!(error.to_string().contains(expected), "{error}");
        }
    }
}
