//! Loads a machine for FMUs, studies and Python: a shipped one by its name, a complete file, or a
//! file that has `"extends"` with the name of another machine and only the fields that differ.

use crate::angles;
use crate::check::{Findings, MachineError};
use crate::per_axis::{SECTIONS_PER_AXIS, is_split, split};
use crate::{Machine, json, shape};
use serde_json::{Map, Value};
use std::fs;
use std::path::{Path, PathBuf};

/// Names (for `extends` and `machine_file`) and JSON texts of the shipped machines.
pub const PRESETS: [(&str, &str); 3] = [
    ("reference", crate::REFERENCE_JSON),
    ("sized", crate::SIZED_JSON),
    ("hiab_xs031", crate::HIAB_XS031_JSON),
];

/// The JSON text of the shipped machine `name`.
pub fn preset(name: &str) -> Option<&'static str> {
    let found = PRESETS.iter().find(|(known, _)| *known == name);
    found.map(|(_, text)| *text)
}

/// A machine with the texts that it was read from: the file itself, then each file it extends.
#[derive(Debug)]
pub struct Source {
    /// The machine.
    pub machine: Machine,
    /// The texts.
    pub texts: Vec<String>,
}

impl Source {
    /// Reads the machine of `text`. A relative path in `extends` is relative to the folder of
    /// `file`, or to the working directory. The error has everything that is wrong.
    pub fn read(text: &str, file: Option<&Path>) -> Result<Self, MachineError> {
        let mut texts = Vec::new();
        let mut open = Vec::from_iter(file.map(canonical));
        let mut found = Findings::default();
        let mut value = merge(text, file, &mut open, &mut texts, &mut found)?;
        shape::check(&mut value, &mut found, true);
        let machine: Machine = serde_json::from_value(value)?;
        let of_shape = found.list.len();
        machine.examine(&mut found);
        found.drop_consequences(of_shape);
        found.result()?;
        Ok(Self { machine, texts })
    }

    /// Name of the shipped machine that this one is, or extends directly or through other files.
    pub fn shipped(&self) -> Option<&'static str> {
        let name = |text: &String| PRESETS.iter().find(|(_, shipped)| shipped == text);
        self.texts.iter().find_map(name).map(|(name, _)| *name)
    }

    /// Reads the shipped machine `name`, or the file with this path.
    pub fn named(name: &str) -> Result<Self, MachineError> {
        match preset(name) {
            Some(text) => Self::read(text, None),
            None => {
                let file = Path::new(name);
                let text = fs::read_to_string(file).map_err(|e| unknown_machine(name, file, &e))?;
                Self::read(&text, Some(file))
            }
        }
    }
}

impl Machine {
    /// Reads and checks a machine. The error has line and column of malformed JSON, or path, value
    /// and rule of every field that is unknown, missing, of a wrong type or out of its range.
    pub fn from_json(json: &str) -> Result<Self, MachineError> {
        Ok(Source::read(json, None)?.machine)
    }

    /// As [`Machine::from_json`], with relative paths in `extends` from the folder of `file`.
    pub fn from_text(text: &str, file: &Path) -> Result<Self, MachineError> {
        Ok(Source::read(text, Some(file))?.machine)
    }

    /// The shipped machine `name`; an empty name is the reference machine.
    pub fn preset(name: &str) -> Option<Self> {
        if ["", "reference"].contains(&name) {
            return Some(Self::reference());
        }
        preset(name).map(|text| Self::from_json(text).expect("a shipped machine is valid"))
    }
}

/// A path that is the same for the same file.
fn canonical(file: &Path) -> PathBuf {
    fs::canonicalize(file).unwrap_or_else(|_| file.to_path_buf())
}

fn unknown_machine(name: &str, file: &Path, error: &std::io::Error) -> MachineError {
    let names: Vec<_> = PRESETS.iter().map(|(name, _)| *name).collect();
    let near = shape::nearest(name, names.iter().copied());
    let near = near.map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
    MachineError::Source(format!(
        "`{name}` must be a shipped machine ({}) or a file; {}: {error}{near}",
        names.join(", "),
        file.display()
    ))
}

/// The JSON object of `text`, merged onto the machine that it extends. `open` are the files being
/// read (to find cycles), `texts` collects the text of every file.
fn merge(
    text: &str,
    file: Option<&Path>,
    open: &mut Vec<PathBuf>,
    texts: &mut Vec<String>,
    found: &mut Findings,
) -> Result<Value, MachineError> {
    texts.push(text.to_owned());
    let Value::Object(mut own) = json::parse(text)? else {
        return Err(MachineError::Source(
            "machine JSON: it must be one object".into(),
        ));
    };
    own.remove("$schema");
    let base = own.remove("extends");
    let mut own = Value::Object(own);
    angles::unify(&mut own, found);
    shape::check(&mut own, found, false);
    let base = match base {
        None => return Ok(own),
        Some(Value::String(name)) => name,
        Some(other) => {
            let rule = "the name of a shipped machine or the path of a machine file, as a string";
            found.refuse("extends", other, rule);
            return Ok(own);
        }
    };
    let in_base = |error| MachineError::Base {
        name: base.clone(),
        error: Box::new(error),
    };
    let mut value = read_base(&base, file, open, texts).map_err(in_base)?;
    overlay(&mut value, own, true);
    Ok(value)
}

/// The JSON object of the machine `name` that `file` extends.
fn read_base(
    name: &str,
    file: Option<&Path>,
    open: &mut Vec<PathBuf>,
    texts: &mut Vec<String>,
) -> Result<Value, MachineError> {
    let mut found = Findings::default();
    let value = if let Some(text) = preset(name) {
        merge(text, None, open, texts, &mut found)?
    } else {
        let folder = file.and_then(Path::parent).unwrap_or(Path::new(""));
        let path = folder.join(name);
        let text = fs::read_to_string(&path).map_err(|e| unknown_machine(name, &path, &e))?;
        let this = canonical(&path);
        if open.contains(&this) {
            let path = path.display();
            return Err(MachineError::Source(format!(
                "{path} must not extend itself, directly or through other files"
            )));
        }
        open.push(this);
        let value = merge(&text, Some(&path), open, texts, &mut found)?;
        open.pop();
        value
    };
    found.result()?;
    Ok(value)
}

/// Overwrites `base` with `own`: objects field by field, everything else (arrays, too) as a whole.
/// If one of the two has an object for each actuator, so has the result.
fn overlay(base: &mut Value, own: Value, is_whole: bool) {
    let (Value::Object(base), Value::Object(own)) = (&mut *base, &own) else {
        *base = own;
        return;
    };
    for (key, mut value) in own.clone() {
        let Some(place) = base.get_mut(&key) else {
            base.insert(key, value);
            continue;
        };
        if is_whole
            && SECTIONS_PER_AXIS.contains(&key.as_str())
            && is_split(place) != is_split(&value)
        {
            split(place);
            split(&mut value);
        }
        overlay(place, value, false);
    }
}

/// The JSON of a file that extends the machine `base`, called `name`, and has only the fields in
/// which `machine` differs.
pub fn extension_of(name: &str, base: &Machine, machine: &Machine) -> Value {
    let [mut base, mut machine] =
        [base, machine].map(|m| serde_json::to_value(m).expect("numbers and names"));
    for section in SECTIONS_PER_AXIS {
        if is_split(&base[section]) != is_split(&machine[section]) {
            split(&mut base[section]);
            split(&mut machine[section]);
        }
    }
    let mut file = Map::from_iter([("extends".to_owned(), name.into())]);
    if let Some(Value::Object(differs)) = difference(&base, &machine) {
        file.extend(differs);
    }
    Value::Object(file)
}

/// The part of `value` that differs from `base`: [`overlay`] puts it back.
fn difference(base: &Value, value: &Value) -> Option<Value> {
    let (Value::Object(fields), Value::Object(known)) = (value, base) else {
        return (value != base).then(|| value.clone());
    };
    let differing = fields.iter().filter_map(|(key, value)| {
        let differs = match known.get(key) {
            Some(base) => difference(base, value),
            None => Some(value.clone()),
        };
        differs.map(|value| (key.clone(), value))
    });
    let differing: Map<_, _> = differing.collect();
    (!differing.is_empty()).then_some(Value::Object(differing))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use tempfile::TempDir;

    fn read(value: &Value) -> Result<Machine, MachineError> {
        Machine::from_json(&value.to_string())
    }

    #[test]
    fn what_a_file_does_not_say_is_that_of_its_base() {
        let mut expected = Machine::reference();
        assert_eq!(
            read(&json!({"extends": "reference"})).expect("valid"),
            expected
        );
        expected.geometry.d4 = 0.345;
        expected.geometry.C_in_tilt = [0.23, 0.01];
        expected.emla.slew.inverter = None;
        expected.emla.lift.inverter = None;
        expected.emla.tilt.inverter = None;
        expected.emla.lift.R_s = 0.7;
        let mut own = json!({
            "$schema": "machine.schema.json",
            "extends": "reference",
            "geometry": {"d4": 0.345, "C_in_tilt": [0.23, 0.01]},
            "emla": {"lift": {"R_s": 0.7, "inverter": null}, "slew": {"inverter": null}, "tilt": {"inverter": null}},
        });
        assert_eq!(read(&own).expect("valid"), expected);
        // What is said once for all actuators counts for each of a base that tells them apart.
        own["extends"] = "sized".into();
        own["emla"] = json!({"C_b": 7e5});
        let machine = read(&own).expect("valid");
        let sized = Machine::preset("sized").expect("shipped");
        for (emla, sized) in machine
            .emla
            .in_order()
            .into_iter()
            .zip(sized.emla.in_order())
        {
            assert_eq!(*emla, crate::Emla { C_b: 7e5, ..*sized });
        }
    }

    #[test]
    fn all_shipped_machines_are_valid_and_known_by_name() {
        for (name, _) in PRESETS {
            let machine = Machine::preset(name).expect("shipped");
            assert_eq!(machine, read(&json!({"extends": name})).expect("valid"));
            let source = Source::named(name).expect("valid");
            assert_eq!((source.shipped(), source.machine), (Some(name), machine));
        }
        assert_eq!(Machine::preset(""), Some(Machine::reference()));
        assert_eq!(Machine::preset("none"), None);
    }

    #[test]
    fn paths_start_from_the_folder_of_the_file_that_extends() {
        let folder = TempDir::new().expect("folder");
        let place = |name: &str| folder.path().join(name);
        fs::create_dir(place("inner")).expect("folder");
        let write =
            |name: &str, value: &Value| fs::write(place(name), value.to_string()).expect("written");
        write(
            "inner/base.json",
            &json!({"extends": "../lowest.json", "gravity": 3.7}),
        );
        write(
            "lowest.json",
            &json!({"extends": "reference", "gravity": 1.6, "geometry": {"r_B": 0.4}}),
        );
        write("top.json", &json!({"extends": "inner/base.json"}));
        let name = place("top.json").display().to_string();
        let source = Source::named(&name).expect("valid");
        assert_eq!(
            (source.machine.gravity, source.machine.geometry.r_B),
            (3.7, 0.4)
        );
        assert_eq!(source.texts.len(), 4);
        assert_eq!(source.shipped(), Some("reference"));
        // A circle of two, and a file of itself.
        write("lowest.json", &json!({"extends": "inner/base.json"}));
        let refused = Source::named(&name).expect_err("a circle").to_string();
        assert!(
            refused.ends_with("must not extend itself, directly or through other files"),
            "{refused}"
        );
        write("top.json", &json!({"extends": "./top.json"}));
        let refused = Source::named(&name).expect_err("a circle").to_string();
        assert!(refused.contains("must not extend itself"), "{refused}");
        write(
            "lowest.json",
            &json!({"extends": "reference", "gravity": -1, "bodies": {"A2": {"mas": 3}}}),
        );
        write("top.json", &json!({"extends": "lowest.json"}));
        let lines = Source::named(&name).expect_err("refused").lines();
        assert_eq!(
            lines,
            [
                "`extends` = \"lowest.json\": `bodies.A2.mas` is an unknown field; did you mean `mass`?"
            ]
        );
    }

    #[test]
    fn a_base_that_does_not_exist_is_refused_with_the_names_that_do() {
        let refused = read(&json!({"extends": "referense"}))
            .expect_err("refused")
            .to_string();
        for part in [
            "`referense`",
            "reference, sized, hiab_xs031",
            "did you mean `reference`?",
        ] {
            assert!(refused.contains(part), "{part}: {refused}");
        }
        let refused = read(&json!({"extends": 3}))
            .expect_err("refused")
            .to_string();
        assert!(
            refused.starts_with("`extends` = 3 must be the name"),
            "{refused}"
        );
    }

    /// Unknown, misspelt, missing, of another type, beyond its range: one line each, and none that
    /// only follows from another.
    #[test]
    fn everything_wrong_is_told_at_once() {
        let mut value: Value = serde_json::from_str(crate::REFERENCE_JSON).expect("JSON");
        value["emla"]["r_s"] = value["emla"]["R_s"].take();
        value["emla"].as_object_mut().expect("object").remove("R_s");
        value["emla"]["p"] = 4.5.into();
        value["emla"]["core"]["k_h"] = (-1.0).into();
        value["geometry"]
            .as_object_mut()
            .expect("object")
            .remove("d4");
        value["geometry"]["r_O_B"] = json!([2.0, 0.0]);
        value["geometry"]["E_in_boom"][1] = "low".into();
        value["bodies"]["T1"]["mass"] = (-650).into();
        value["trajectories"]["cubic"]["vertices"][3][1] = json!([]);
        let lines = read(&value).expect_err("refused").lines();
        let expected = [
            "`emla.r_s` is an unknown field; did you mean `R_s`?",
            "`emla.p` = 4.5 must be a whole number",
            "`geometry.E_in_boom[2]` = \"low\" must be a number",
            "`geometry.r_O_B` = [2.0,0.0] must be an array of 3 elements",
            "`trajectories.cubic.vertices[4][2]` = [] must be a number",
            "`emla.R_s` is missing",
            "`geometry.d4` is missing",
            "`bodies.T1.mass` = -650 must be finite and > 0",
            "`emla.core.k_h` = -1 must be finite and ≥ 0",
        ];
        let sorted = |mut lines: Vec<String>| {
            lines.sort();
            lines
        };
        assert_eq!(sorted(lines), sorted(expected.map(String::from).to_vec()));
    }

    #[test]
    fn a_file_of_the_differences_is_the_machine() {
        for (name, _) in PRESETS {
            for (other, _) in PRESETS {
                let [base, machine] =
                    [name, other].map(|name| Machine::preset(name).expect("shipped"));
                let file = extension_of(name, &base, &machine);
                assert_eq!(read(&file).expect("valid"), machine, "{other} on {name}");
            }
        }
        let base = Machine::reference();
        let mut machine = base.clone();
        machine.emla.tilt.core = None;
        machine.bodies.PL.mass = 12.0;
        let file = extension_of("reference", &base, &machine);
        assert_eq!(file["bodies"], json!({"PL": {"mass": 12.0}}));
        assert_eq!(file["emla"], json!({"tilt": {"core": null}}));
    }

    #[test]
    fn a_key_that_is_there_twice_is_refused() {
        let text = r#"{"extends": "reference", "gravity": 9.8, "gravity": 9.9}"#;
        let refused = Machine::from_json(text).expect_err("refused").to_string();
        assert!(
            refused.contains("duplicate field `gravity` at line 1"),
            "{refused}"
        );
    }
}
