//! [`Inscription`]: a place in a library for a machine that is written there after the library was
//! built, and [`inscribe`], which writes it: `hdrm-fmu machine pack` makes libraries whose machine,
//! start values and name are another's, wherever they run, also without files.

use std::hint::black_box;

use crate::{Machine, MachineError};

/// What the place begins with in the file of a library.
const MARK: &[u8; 24] = b"place-for-a-machine-file";
/// Bytes for the size of the place.
const SIZE: usize = 8;
/// Largest text, bytes.
const CAPACITY: usize = 1 << 14;
const START: usize = MARK.len() + SIZE;
/// Follows the text; not in UTF-8.
const END: u8 = 0xff;

/// A place for a machine and its name, in a `static` with `#[used]`, one in a library.
pub struct Inscription([u8; START + CAPACITY]);

/// A machine with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Inscribed {
    /// Its name, a part of an identifier.
    pub name: String,
    /// The machine.
    pub machine: Machine,
}

impl Inscription {
    /// Nothing is written there yet.
    pub const fn empty() -> Self {
        let mut bytes = [END; START + CAPACITY];
        let (size, mut k) = ((CAPACITY as u64).to_le_bytes(), 0);
        while k < START {
            bytes[k] = if k < MARK.len() {
                MARK[k]
            } else {
                size[k - MARK.len()]
            };
            k += 1;
        }
        Self(bytes)
    }

    /// What is written there.
    pub fn read(&self) -> Option<Result<Inscribed, MachineError>> {
        // The compiler knows what was there when it was built.
        let text = &black_box(self).0[START..];
        let end = text.iter().position(|byte| *byte == END);
        let text = String::from_utf8_lossy(&text[..end.unwrap_or(text.len())]);
        let (name, json) = text.split_once('\n')?;
        Some(Machine::from_json(json).map(|machine| Inscribed {
            name: name.into(),
            machine,
        }))
    }
}

/// Writes the machine of the text `json`, called `name`, into the file of a library.
///
/// # Errors
/// The library has no place for it, or the text is too long.
pub fn inscribe(library: &mut [u8], name: &str, json: &str) -> Result<(), MachineError> {
    let wrong = |text: String| Err(MachineError::Source(text));
    let mut places = library.windows(MARK.len()).enumerate();
    let mut places = places.by_ref().filter(|(_, bytes)| bytes == MARK);
    let (Some((at, _)), None) = (places.next(), places.next()) else {
        return wrong("it has no place for a machine".into());
    };
    let size = |bytes: &[u8]| bytes.try_into().map(u64::from_le_bytes).ok();
    let size = library.get(at + MARK.len()..at + START).and_then(size);
    let place = size.and_then(|size| {
        let end = (at + START).checked_add(usize::try_from(size).ok()?)?;
        library.get_mut(at + START..end)
    });
    let Some(place) = place else {
        return wrong("its place for a machine is damaged".into());
    };
    let text = format!("{name}\n{json}");
    if text.len() > place.len() {
        let (size, most) = (text.len(), place.len());
        return wrong(format!(
            "the machine takes {size} bytes of JSON; at most {most} fit into a library"
        ));
    }
    let (written, rest) = place.split_at_mut(text.len());
    written.copy_from_slice(text.as_bytes());
    rest.fill(END);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_that_was_written_is_read() {
        let mut place = Box::new(Inscription::empty());
        assert!(place.read().is_none());
        let machine = Machine::preset("hiab_xs031").expect("shipped");
        let json = serde_json::to_string(&machine).expect("numbers and names");
        // The second one is shorter.
        for (name, json) in [("longer", &*format!("{json}   ")), ("crane", &json)] {
            let mut library = [b"before", &place.0[..], b"\xff\xffafter"].concat();
            inscribe(&mut library, name, json).expect("a place");
            assert_eq!(&library[library.len() - 7..], b"\xff\xffafter");
            place.0.copy_from_slice(&library[6..6 + START + CAPACITY]);
            let read = place.read().expect("written").expect("valid");
            assert_eq!((&*read.name, &read.machine), (name, &machine));
        }
    }

    #[test]
    fn what_cannot_be_written_is_refused() {
        let place = Inscription::empty().0;
        let long = " ".repeat(CAPACITY);
        for (library, json, words) in [
            (b"none".to_vec(), "{}", "no place"),
            ([place, place].concat(), "{}", "no place"),
            (place[..START + 9].to_vec(), "{}", "damaged"),
            (place.to_vec(), &*long, "at most 16384 fit"),
        ] {
            let mut written = library.clone();
            let error = inscribe(&mut written, "a", json).expect_err("refused");
            assert!(error.to_string().contains(words), "{error}");
            assert!(written == library, "{words}: it stays as it was");
        }
    }
}
