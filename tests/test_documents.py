"""Texts and what publishes them: links lead somewhere, the README is short, a release's files are what docs/project/releasing.md says."""

import hashlib
import re
import runpy
import subprocess
import tarfile
import tomllib
import zipfile

import pytest
import yaml

from fmpy_master import ROOT

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)|<img src=\"([^\"]+)\"")


def pages():
    """Every Markdown file of the project."""
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [ROOT / name for name in listed.split()]


def without_code(text):
    return re.sub(r"^```.*?^```|`[^`\n]*`", "", text, flags=re.MULTILINE | re.DOTALL)


def anchors(page):
    """Of the headings of a page, as GitHub makes them."""
    headings = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```", "", page.read_text(), flags=re.MULTILINE | re.DOTALL), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_to_files_and_headings(page):
    wrong = []
    for target in (first or second for first, second in LINK.findall(without_code(page.read_text()))):
        if re.match(r"\w+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        if not file.exists() or (anchor and anchor not in anchors(file)):
            wrong.append(target)
    assert wrong == []


def test_the_readme_is_for_the_first_five_minutes():
    lines = (ROOT / "README.md").read_text().splitlines()
    assert len(lines) <= 150 and max(map(len, lines)) <= 140


def test_the_readme_says_how_long_how_much_disk_and_which_door_is_whose():
    text = " ".join((ROOT / "README.md").read_text().split())
    assert "`demo` prints the table after two to four minutes and has written the report after four to eight" in text
    assert "takes 0.6 GB of disk" in text and "side by side" in text
    doors = text[text.index("## Four doors") : text.index("## Use it")]
    for door in ("run the machine", "export a model of your own", "script runs", "test an importer, or FMUs in your CI"):
        assert f"| {door}" in doors, door


def test_every_page_is_in_the_index():
    index = (ROOT / "docs/README.md").read_text()
    names = [page.relative_to(ROOT / "docs").as_posix() for page in sorted((ROOT / "docs").rglob("*.md"))]
    assert [name for name in names if not name.endswith("README.md") and f"({name})" not in index] == []


def test_the_tests_page_names_every_file():
    page = (ROOT / "tests/README.md").read_text()
    files = [path for pattern in ("*.py", "oracle/*.py", "bench/*") for path in sorted((ROOT / "tests").glob(pattern)) if path.is_file()]
    assert [path.name for path in files if path.name not in page] == []


@pytest.fixture
def handed_out(tmp_path):
    """A folder like that of `cargo xtask dist`."""
    folder = tmp_path / "dist"
    for name in ("Emla.fmu", "fmi3/Emla.fmu", "Manipulator.ssp", "machine.html", "cosim_page.wasm", "linux64/cosim", "win64/cosim.exe", "aarch64-linux/cosim", "python/hdrm_fmu-0.1.0.whl", "README.md"):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(name)
    (folder / "linux64/cosim").chmod(0o755)
    return folder


def test_a_release_has_archives_single_files_and_checksums(handed_out, tmp_path):
    main = runpy.run_path(str(ROOT / ".github/archives.py"))["main"]
    main(handed_out, "0.1.0", tmp_path / "one")
    main(handed_out, "0.1.0", tmp_path / "two")
    made = {path.name: path.read_bytes() for path in (tmp_path / "one").iterdir()}
    assert made == {path.name: path.read_bytes() for path in (tmp_path / "two").iterdir()}, "made twice, the same bytes"
    assert {"Emla.fmu", "fmi3-Emla.fmu", "Manipulator.ssp", "machine.html", "cosim_page.wasm", "hdrm_fmu-0.1.0.whl", "hdrm-fmu-0.1.0.tar.gz", "hdrm-fmu-0.1.0-win64.zip", "SHA256SUMS"} == set(made)
    sums = dict(reversed(line.split("  ")) for line in made.pop("SHA256SUMS").decode().splitlines())
    assert sums == {name: hashlib.sha256(data).hexdigest() for name, data in made.items()}
    with tarfile.open(tmp_path / "one/hdrm-fmu-0.1.0.tar.gz") as archive:
        assert archive.getmember("hdrm-fmu-0.1.0/linux64/cosim").mode == 0o755 and len(archive.getnames()) == 10
    with zipfile.ZipFile(tmp_path / "one/hdrm-fmu-0.1.0-win64.zip") as archive:
        assert not any(name.split("/")[1] in ("linux64", "aarch64-linux", "python") for name in archive.namelist())


def test_the_workflow_of_a_release_drafts_what_it_built():
    workflow = yaml.safe_load((ROOT / ".github/workflows/release.yml").read_text())
    commands = [step.get("run", "") for job in workflow["jobs"].values() for step in job["steps"]]
    assert workflow[True]["push"]["tags"] == ["v*"] and workflow["jobs"]["draft"]["needs"] == "build"
    assert "cargo xtask dist --check" in commands and any("--draft" in command for command in commands)


def published():
    """Folders of the crates that a registry may have, by name."""
    manifests = subprocess.run(["git", "ls-files", "*/Cargo.toml"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    read = {ROOT / file: tomllib.loads((ROOT / file).read_text()) for file in manifests if "template" not in file}
    return {crate["package"]["name"]: file.parent for file, crate in read.items() if crate["package"].get("publish") is True}


def test_published_crates_bring_readme_and_licences_and_need_no_other_crate():
    """What `cargo xtask test --nightly` packs and builds from the packages."""
    crates = published()
    assert {"fmu-export", "cargo-fmu", "fmi-description"} <= set(crates)
    workspace = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["dependencies"]
    ours = {name for name, at in workspace.items() if isinstance(at, dict) and "path" in at}
    for name, folder in crates.items():
        crate = tomllib.loads((folder / "Cargo.toml").read_text())
        assert (folder / "README.md").is_file() and crate["package"]["readme"] == "README.md", name
        for licence in ("LICENSE-APACHE", "LICENSE-MIT"):
            assert (folder / licence).read_text() == (ROOT / licence).read_text(), f"{name}: {licence}"
        needed = (set(crate.get("dependencies", {})) & ours) - set(crates)
        assert not needed, f"{name} needs {needed}, which no registry will have"
