//! Takes over files that a user has edited in the FMU's `resources` folder, in place of what is
//! compiled in, when `c_api` makes an instance. A host without that folder, such as one of
//! WebAssembly, gets what is compiled in.

use super::fault::Fault;
use super::instance::Instance;
use super::message::Kind;
use super::parameter_file::{exists, read};
use super::storage::Storage;
use crate::Model;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

impl<M: Model> Instance<M> {
    /// Takes over the files in the `resources` folder that String parameters stand for by default
    /// and that differ from what is compiled in.
    pub(crate) fn take_packed_files(&mut self) -> Result<(), String> {
        let Some(folder) = self.resources.clone() else {
            return Ok(());
        };
        let (mut found, mut missing) = (BTreeMap::new(), Vec::new());
        for (_, row) in self.layout.rows() {
            let Storage::Text(get, _) = &row.storage else {
                continue;
            };
            let start = get(&self.start);
            let path = row.packed_file.map_or(start, |packed| packed.path);
            if path.is_empty() || Path::new(path).is_absolute() {
                continue;
            }
            let file = folder.join(path);
            let edited = match row.packed_file {
                Some(packed) => packed.edited_text(&folder),
                None => read(&file).map(Some),
            };
            match edited {
                Err(error) if error.kind() == ErrorKind::NotFound => missing.push(format!(
                    "`{}`: there is no `{path}` in the resources folder {}; the one that is compiled in is used",
                    row.name,
                    folder.display()
                )),
                Err(error) => {
                    return Err(format!("`{}`: file `{}`: {error}", row.name, file.display()));
                }
                Ok(None) => {}
                Ok(Some(_)) => {
                    found.insert(row.name, path.to_owned());
                }
            }
        }
        if !missing.is_empty() && exists(&folder).unwrap_or(false) {
            for text in missing {
                self.report(Kind::Event, text);
            }
        }
        if found.is_empty() {
            return Ok(());
        }
        self.packed_texts = found;
        let (start, settings) = (self.start.clone(), self.state.settings.clone());
        let texts = self.texts(&start, &settings);
        let parameters = self.composed(&texts, &start, &settings);
        let parameters = parameters.map_err(|fault| match fault {
            Fault::Refused(text) | Fault::Discarded(text) => format!(
                "{text}; the file is in the FMU's resources folder {} and counts before the one that is compiled in",
                folder.display()
            ),
            Fault::Unknown(number) => format!("no variable has the number {number}"),
        })?;
        let bytes = |p: &M::Parameters| postcard::to_extend(p, Vec::new()).ok();
        if bytes(&parameters) == bytes(&start) {
            self.packed_texts.clear();
            return Ok(());
        }
        let files: Vec<_> = self
            .packed_texts
            .values()
            .map(|file| format!("`{file}`"))
            .collect();
        let text = format!(
            "{} in the resources folder {} differs from what is compiled in, and is used",
            files.join(" and "),
            folder.display()
        );
        self.report(Kind::Event, text);
        self.state.parameters = parameters.clone();
        self.packed_start = Some(parameters);
        Ok(())
    }
}
