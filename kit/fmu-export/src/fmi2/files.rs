//! The files of an FMU for FMI 2.0 other than its binaries, which `cargo fmu pack` reads.

use super::description::model_description_with_sizes;
use crate::Model;
use crate::c_api::files::{Packed, folders};

/// Model description, icon, documentation and resources.
pub(crate) fn files<M: Model>(sizes: &str) -> Result<Vec<Packed>, String> {
    let xml = model_description_with_sizes::<M>(sizes)?.into_bytes();
    let mut files = vec![("modelDescription.xml".to_owned(), xml.into())];
    if !M::INFO.icon.is_empty() {
        files.push(("model.png".to_owned(), M::INFO.icon.into()));
    }
    files.extend(folders::<M>());
    Ok(files)
}
