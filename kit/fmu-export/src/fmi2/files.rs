//! The files of an FMU of FMI 2.0 beside the binaries.

use super::description::model_description_with_sizes;
use crate::Model;
use crate::c_api::files::{Packed, folders};

/// All of them: model description, icon, documentation, resources.
pub(crate) fn files<M: Model>(sizes: &str) -> Result<Vec<Packed>, String> {
    let xml = model_description_with_sizes::<M>(sizes)?.into_bytes();
    let mut files = vec![("modelDescription.xml".to_owned(), xml.into())];
    if !M::INFO.icon.is_empty() {
        files.push(("model.png".to_owned(), M::INFO.icon.into()));
    }
    files.extend(folders::<M>());
    Ok(files)
}
