//! The files of an FMU for FMI 3.0 other than its binaries, which `cargo fmu pack` reads.

use super::description::{model_description_with_sizes, terminals};
use crate::Model;
use crate::c_api::files::{Packed, folders};

/// Model description, terminals and icon, documentation and resources.
pub(crate) fn files<M: Model>(sizes: &str) -> Result<Vec<Packed>, String> {
    let xml = model_description_with_sizes::<M>(sizes)?.into_bytes();
    let mut files = vec![("modelDescription.xml".to_owned(), xml.into())];
    if let Some(xml) = terminals::text::<M>()? {
        let path = "terminalsAndIcons/terminalsAndIcons.xml".to_owned();
        files.push((path, xml.into_bytes().into()));
    }
    if !M::INFO.icon.is_empty() {
        files.push(("terminalsAndIcons/icon.png".to_owned(), M::INFO.icon.into()));
    }
    files.extend(folders::<M>());
    Ok(files)
}
