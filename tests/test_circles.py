"""Files of a crate do not import each other in circles: a file can be read after those that it uses."""

from circles import crates, report


def test_no_files_import_each_other_in_circles():
    reports = [report(crate) for crate in crates()]
    assert len(reports) > 20
    found = sum(len(files) for _, files in reports)
    message = [f"{found} files in circles: move what both sides need into a file of its own", *(text for texts, _ in reports for text in texts)]
    assert found == 0, "\n".join(message)


def files_in_circles(folder, **sources):
    """Of a crate of these files, by name; `__` in a name is a folder."""
    for name, text in sources.items():
        file = folder / "src" / f"{name.replace('__', '/')}.rs"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return {file.stem for file in report(folder)[1]}


def test_a_child_that_imports_what_its_parent_defines_is_in_a_circle(tmp_path):
    parent = "mod child;\nuse child::{Made as Other, make};\npub struct Kind;\nfn f() { make() }"
    child = "use super::Kind;\npub struct Made(Kind);\npub fn make() {}"
    assert files_in_circles(tmp_path, lib="pub mod parent;", parent=parent, parent__child=child) == {"parent", "child"}


def test_a_parent_that_re_exports_only_is_in_none(tmp_path):
    lib = "mod one;\nmod two;\npub struct Kind;\npub use one::One;\npub use two::Two;"
    assert files_in_circles(tmp_path, lib=lib, one="use crate::Kind;\npub struct One(Kind);", two="use crate::One;\npub struct Two(One);") == set()


def test_a_circle_through_re_exports_is_found_where_the_names_are_defined(tmp_path):
    lib = "mod one;\nmod two;\nmod three;\npub use one::*;\npub use two::Two;"
    sources = {"one": "use crate::Two;\npub struct One;", "two": "use super::three::{Three};\npub struct Two;", "three": "use crate::One;\npub struct Three;"}
    assert files_in_circles(tmp_path, lib=lib, **sources) == {"one", "two", "three"}


def test_tests_comments_and_texts_are_left_out(tmp_path):
    one = 'pub struct One;\n// use crate::two::Two;\nconst T: &str = "use crate::two::Two;";\n#[cfg(test)]\nmod tests {\n    use crate::two::Two;\n}'
    assert files_in_circles(tmp_path, lib="mod one;\nmod two;", one=one, two="use crate::one::One;\npub struct Two;") == set()


def test_a_circle_of_written_out_paths_is_found(tmp_path):
    one = "pub struct One;\npub fn one() -> crate::two::Two { super::two::two() }"
    two = "pub struct Two(crate::one::One);\npub fn two() {}"
    assert files_in_circles(tmp_path, lib="mod one;\nmod two;", one=one, two=two) == {"one", "two"}


def test_a_path_within_a_child_and_back_is_a_circle(tmp_path):
    parent = "mod child;\npub const LONG: u8 = 9;\nfn f() { child::make() }"
    child = "pub fn make() -> u8 { super::LONG }"
    assert files_in_circles(tmp_path, lib="mod parent;", parent=parent, parent__child=child) == {"parent", "child"}
