//! Enumerations for tables, handwritten or derived: the names of an Integer row's numbers, and the
//! Rust values that they stand for.

use super::error::ModelError;

/// An enumeration type; its items are numbered from 1.
#[derive(Clone, Copy, Debug)]
pub struct Enumeration {
    pub(crate) name: &'static str,
    pub(crate) description: &'static str,
    pub(crate) items: &'static [(&'static str, &'static str)],
}

impl Enumeration {
    /// `items` are (name, description); the first has the value 1.
    pub const fn new(
        name: &'static str,
        description: &'static str,
        items: &'static [(&'static str, &'static str)],
    ) -> Self {
        Self {
            name,
            description,
            items,
        }
    }
}

/// An enumeration whose items stand for values of a Rust type `T`, which may belong to another crate.
///
/// ```
/// # use fmu_export::Items;
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// enum Drive { Motion, Force }
///
/// static DRIVE: Items<Drive, 2> = Items::new("Drive", "who moves the rod", [
///     (Drive::Motion, "motion", "a mechanism"),
///     (Drive::Force, "force", "the actuator"),
/// ]);
///
/// assert_eq!(DRIVE.number(Drive::Force), 2);
/// assert_eq!(DRIVE.item(2).unwrap(), Drive::Force);
/// let text = DRIVE.item(3).unwrap_err().to_string();
/// assert_eq!(text, "`Drive` = 3 must be 1 (motion) or 2 (force)");
/// ```
///
/// [`Variable::items`](crate::Variable::items) makes a row an enumeration of these items.
#[derive(Debug)]
pub struct Items<T, const N: usize> {
    name: &'static str,
    description: &'static str,
    /// Names and descriptions.
    items: [(&'static str, &'static str); N],
    values: [T; N],
}

impl<T: Copy, const N: usize> Items<T, N> {
    /// `items` are (value, name, description), at least one; the first has the number 1.
    pub const fn new(
        name: &'static str,
        description: &'static str,
        items: [(T, &'static str, &'static str); N],
    ) -> Self {
        let (mut names, mut values) = ([("", ""); N], [items[0].0; N]);
        let mut k = 0;
        while k < N {
            names[k] = (items[k].1, items[k].2);
            values[k] = items[k].0;
            k += 1;
        }
        Self {
            name,
            description,
            items: names,
            values,
        }
    }

    /// The value of the item with this number.
    ///
    /// # Errors
    /// No item has the number.
    pub fn item(&self, number: i32) -> Result<T, ModelError> {
        let index = usize::try_from(number).ok().and_then(|n| n.checked_sub(1));
        let value = index.and_then(|index| self.values.get(index));
        value.copied().ok_or_else(|| {
            let (name, allowed) = (self.name, numbered(&self.items));
            ModelError::new(format!("`{name}` = {number} must be {allowed}"))
        })
    }

    /// The number of the item with this value.
    ///
    /// # Panics
    /// No item has the value.
    pub fn number(&self, value: T) -> i32
    where
        T: PartialEq,
    {
        let index = self.values.iter().position(|v| *v == value);
        index.expect("an item stands for each value") as i32 + 1
    }
}

impl<T, const N: usize> Items<T, N> {
    /// The enumeration for the model description.
    pub(crate) const fn enumeration(&'static self) -> Enumeration {
        Enumeration::new(self.name, self.description, &self.items)
    }
}

/// The items with their numbers, for messages: `1 (motion) or 2 (force)`.
pub(crate) fn numbered(items: &[(&str, &str)]) -> String {
    let items = (1..).zip(items);
    let items = items.map(|(value, (name, _))| format!("{value} ({name})"));
    Vec::from_iter(items).join(" or ")
}
