//! The files of an FMU beside the binaries.

use super::description::model_description;
use crate::{File, MadeFile, Model};
use std::borrow::Cow;

/// Path inside the FMU, and content.
type Packed = (String, Cow<'static, [u8]>);

/// All of them: model description, icon, documentation, resources.
pub(crate) fn files<M: Model>() -> Result<Vec<Packed>, String> {
    let info = M::INFO;
    let xml = model_description::<M>()?.into_bytes();
    let mut files = vec![("modelDescription.xml".to_owned(), xml.into())];
    if !info.icon.is_empty() {
        files.push(("model.png".to_owned(), info.icon.into()));
    }
    for (folder, list) in [
        ("documentation", info.documentation),
        ("resources", info.resources),
    ] {
        for File { path, bytes } in list {
            files.push((format!("{folder}/{path}"), (*bytes).into()));
        }
    }
    for MadeFile { path, make } in info.made_resources {
        files.push((format!("resources/{path}"), make().into()));
    }
    Ok(files)
}
