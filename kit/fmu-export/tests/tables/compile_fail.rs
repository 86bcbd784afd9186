//! What the derives say of mistakes, and where: each text is compared with the file beside the
//! case. After a change on purpose: `TRYBUILD=overwrite cargo test --release -p fmu-export --test
//! tables mistakes_are_named_where_they_are`, and read what changed.

#[test]
#[cfg_attr(miri, ignore = "Miri starts no processes")]
fn mistakes_are_named_where_they_are() {
    trybuild::TestCases::new().compile_fail("tests/compile_fail/*.rs");
}
