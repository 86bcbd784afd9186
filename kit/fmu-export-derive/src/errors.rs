//! Joins the errors of several fields or variants, for `check`, `enumeration` and `structs`.

use syn::Result;

pub(crate) fn combined(results: impl Iterator<Item = Result<()>>) -> Result<()> {
    let errors = results.filter_map(Result::err);
    let all = errors.reduce(|mut all, next| {
        all.combine(next);
        all
    });
    all.map_or(Ok(()), Err)
}
