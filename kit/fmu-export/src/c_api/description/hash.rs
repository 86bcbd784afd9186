//! The hash that identifies the model (`guid`, `instantiationToken`), for `description`,
//! instantiation and saved states: a UUID v5 of all that the model description says. It is computed
//! from the table, because writing XML would take most of a process's first instantiation.

use super::parts::{declared_types, enumerations, units_in_use};
use crate::core::causality::Dependencies;
use crate::core::enumeration::Enumeration;
use crate::core::info::{Experiment, Info};
use crate::core::layout::Layout;
use crate::core::length::Length;
use crate::core::model::Variable;
use crate::core::sizes::{self, StartValues};
use crate::core::storage::{Storage, each};
use crate::core::value::Value;
use crate::{Model, TypeDefinition, c_api::log::CATEGORIES};
use fmi_units::{DisplayUnit, Unit};
use uuid::Uuid;

/// The hash of a model with these start values, for a version of FMI. It includes the version of
/// this crate, because another version may write another description of the same table.
pub(crate) fn hash<M: Model>(
    layout: &Layout<M>,
    (parameters, input): &StartValues<M>,
    version: [u8; 4],
) -> Uuid {
    let mut all = Bytes(Vec::with_capacity(1 << 14));
    all.text(env!("CARGO_PKG_VERSION"));
    all.0.extend(version);
    all.info(&M::INFO);
    all.each(&units_in_use(layout), |all, (unit, display)| {
        all.unit(unit, display)
    });
    all.each(&enumerations(layout), |all, e| all.enumeration(e));
    for declared in declared_types(layout) {
        all.declared_type(declared);
    }
    let output = sizes::output::<M>(parameters);
    for (elements, row) in layout.rows() {
        all.number(elements.len());
        all.row(row);
        all.start(row, parameters, input, &output);
    }
    for clock in M::CLOCKS {
        all.text(clock.variability());
        all.reals(clock.interval().as_slice());
        all.reals(&[clock.shift]);
    }
    if M::SCHEDULED_EXECUTION {
        all.text("scheduled");
    }
    Uuid::new_v5(&Uuid::NAMESPACE_OID, &all.0)
}

/// The bytes to hash. Texts and lists begin with their length, so that no two tables give the same
/// bytes. Structs are destructured completely, so that the compiler reports a new field here.
struct Bytes(Vec<u8>);

impl Bytes {
    fn number(&mut self, n: usize) {
        self.0.extend((n as u64).to_le_bytes());
    }

    fn flags<const N: usize>(&mut self, flags: [bool; N]) {
        self.0.extend(flags.map(u8::from));
    }

    fn text(&mut self, text: &str) {
        self.number(text.len());
        self.0.extend_from_slice(text.as_bytes());
    }

    fn reals(&mut self, values: &[f64]) {
        self.values(values);
    }

    fn each<T>(&mut self, values: &[T], mut write: impl FnMut(&mut Self, &T)) {
        self.number(values.len());
        for value in values {
            write(self, value);
        }
    }

    fn texts(&mut self, texts: &[&str]) {
        self.each(texts, |all, text| all.text(text));
    }

    fn pairs(&mut self, pairs: &[(&str, &str)]) {
        self.each(pairs, |all, (a, b)| all.texts(&[a, b]));
    }

    fn info(&mut self, info: &Info) {
        let &Info {
            model,
            name_after: _, // below
            description,
            version,
            author,
            copyright,
            license,
            experiment: Experiment { start, stop, step },
            documentation: _,
            icon: _,
            resources: _,
            made_resources: _,
            units: _, // those in use
            log_categories,
            input_derivatives,
            output_derivatives,
            directional_derivatives,
            early_return,
            tolerance,
            terminals: _, // in a file of their own
        } = info;
        self.texts(&[model, description, version, author, copyright, license]);
        self.reals(&[start, stop, step]);
        if let Some(tolerance) = tolerance {
            self.reals(&[tolerance]);
        }
        self.pairs(&CATEGORIES.map(|(name, _, description)| (name, description)));
        self.pairs(log_categories);
        self.flags([
            input_derivatives,
            output_derivatives,
            directional_derivatives,
            early_return,
        ]);
        self.0
            .extend(info.own_name().unwrap_or_default().as_bytes());
    }

    fn unit(&mut self, unit: &Unit, display: &[DisplayUnit]) {
        let &Unit {
            name,
            exponents,
            factor,
            offset,
            display: _, // with those of rows
        } = unit;
        self.text(name);
        self.0.extend(exponents.map(i8::cast_unsigned));
        self.reals(&[factor, offset]);
        self.each(display, |all, shown| {
            let &DisplayUnit {
                name,
                factor,
                offset,
            } = shown;
            all.text(name);
            all.reals(&[factor, offset]);
        });
    }

    fn enumeration(&mut self, enumeration: &Enumeration) {
        let &Enumeration {
            name,
            description,
            items,
        } = enumeration;
        self.texts(&[name, description]);
        self.pairs(items);
    }

    fn declared_type(&mut self, declared: &TypeDefinition) {
        let &TypeDefinition {
            name,
            description,
            quantity,
            relative,
            unit,
            display_unit,
            min,
            max,
            nominal,
        } = declared;
        self.texts(&[name, description, quantity]);
        self.flags([relative]);
        self.texts(unit.as_slice());
        self.texts(display_unit.as_slice());
        self.reals(&[min, max]);
        self.reals(nominal.as_slice());
    }

    fn row<M: Model>(&mut self, row: &Variable<M>) {
        let &Variable {
            name,
            description,
            causality,
            ref storage,
            scalar,
            shape,
            resize: _,
            structural,
            tunable,
            discrete,
            clocks,
            previous,
            not_in_evaluation: _,
            read_by_string_setters: _,
            packed_file: _,
            counter: _,
            at,
            unit,
            own_unit: _, // in use
            each_unit,
            display_unit,
            min,
            max,
            nominal,
            enumeration,
            declared_type,
            aliases,
            is_alias: _,
            mime_type,
            rate_of,
            rate_dependencies: _, // those of another row
            rate_unit: _,
            dependencies: _, // below
            initial_dependencies: _,
        } = row;
        self.texts(&[name, description]);
        self.0.extend([causality as u8, storage.kind() as u8]);
        self.flags([scalar, tunable, discrete]);
        self.each(at.as_slice(), |all, number| all.number(*number as usize));
        for names in [unit.as_slice(), each_unit, display_unit.as_slice()] {
            self.texts(names);
        }
        self.reals(&[min, max]);
        self.reals(nominal.as_slice());
        self.each(enumeration.as_slice(), |all, e| all.text(e.name));
        for initially in [false, true] {
            self.dependencies(row, initially);
        }
        if let Some(of) = rate_of {
            self.texts(&["rate", of]);
        }
        if let Some(declared) = declared_type {
            self.texts(&["type", declared.name]);
        }
        if !aliases.is_empty() {
            self.pairs(aliases);
        }
        if !mime_type.is_empty() {
            self.texts(&["MIME", mime_type]);
        }
        if !clocks.is_empty() {
            self.texts(clocks);
            self.texts(previous.as_slice());
        }
        if structural || !shape.is_empty() {
            self.flags([structural]);
            self.each(shape, |all, length| match length {
                Length::Fixed(n) => all.number(*n),
                Length::Parameter(name) => all.text(name),
            });
        }
    }

    fn dependencies<M: Model>(&mut self, row: &Variable<M>, initially: bool) {
        match (row.same(initially), row.declared(initially)) {
            (Some(lists), _) => {
                self.number(1);
                self.texts(&lists.concat());
            }
            (None, Dependencies::Each(lists)) => {
                self.number(2);
                self.each(lists, |all, names| all.texts(names));
            }
            _ => self.number(0),
        }
    }

    /// The start values of an input, a parameter or a constant; computed variables have none.
    fn start<M: Model>(
        &mut self,
        row: &Variable<M>,
        p: &M::Parameters,
        u: &M::Input,
        y: &M::Output,
    ) {
        if let Some(values) = row.start_values(p, u, y) {
            each!(Values, values, |values| self.values(values));
        }
        if let Storage::Text(get, _) = &row.storage {
            self.text(get(p));
        }
    }

    fn values<T: Value>(&mut self, values: &[T]) {
        self.each(values, |all, value| value.write_bytes(&mut all.0));
    }
}
