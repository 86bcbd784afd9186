"""Which crate may import which, by folder; what lies in a product's folder; licences of the crates that are published. Nothing is built."""

import re
import subprocess
import tomllib

import pytest

from circles import stripped
from fmpy_master import ROOT

#: The crates of each product, by folder, and its folders that are no crates.
PRODUCTS = {
    "fmi": ["fmi-description", "fmi-import", "fmi-units", "fmu-check", "fmu-solver", "output-file"],
    "kit": ["cargo-fmu", "fmu-export", "fmu-export-derive"],
    "master": ["cosim", "cosim-page", "cosim-wasm", "page-files", "system-structure"],
    "machine": ["dclink", "emla", "hdrm", "machine-file", "model-rules", "motion-check", "rig", "sensors", "spatial", "tip-path", "vdc"],
    "studies": ["charts", "experiments", "machine-sheet", "report", "surrogate"],
    "tools": ["fuzz", "torture", "unified-features", "xtask"],
}
NO_CRATES = {"studies": ["machine-page"], "tools": ["benches", "rust-fmi-importer"]}

#: Crates outside of the products' folders: the FMUs and what their tables share, and the Python package's native part, which is a study.
SHELLS = ["fmu-controller", "fmu-dclink", "fmu-emla", "fmu-hdrm", "fmu-rig", "fmu-sensors"]
EXAMPLES = [
    "examples/battery",
    "examples/quarter-car/chassis",
    "examples/quarter-car/wheel",
    "kit/fmu-export/example",
    "kit/fmu-export/example-can/bus",
    "kit/fmu-export/example-can/node",
    "kit/fmu-export/example-derive",
    "kit/fmu-export/example-events",
]

#: Layers that the crates of a layer may import, besides their own.
MAY_IMPORT = {
    "fmi": [],
    "kit": ["fmi"],
    "master": ["fmi"],
    "machine": [],
    "shells": ["machine"],
    "examples": [],
    "studies": ["fmi", "master"],
    "tools": ["fmi", "kit", "master", "machine", "studies"],
}

#: Single crates that a layer's crates, or one crate, may import from elsewhere.
AND_CRATES = {
    "shells": ["fmu-export"],
    "examples": ["fmu-export"],
    "cargo-fmu": ["page-files"],  # `cargo fmu web` writes a page that runs the packed FMUs
    "fuzz": ["actuator-table"],  # the saved states that it damages are of the shells' models
}

#: What the studies take of the machine: limits, checks, parameters and pictures. They compute with the models through FMUs, so an addition
#: needs a reason.
OF_MACHINE = {
    "charts": [],
    "experiments": ["emla", "hdrm", "machine-file", "motion-check", "rig", "spatial", "tip-path"],
    "hdrm-fmu-python": ["machine-file", "motion-check", "tip-path"],
    "machine-sheet": ["hdrm", "machine-file", "motion-check"],
    "report": ["hdrm", "machine-file", "motion-check"],
    "surrogate": ["emla", "machine-file", "rig", "sensors"],
}

#: What tests may import although the crate may not, and why.
TESTS_MAY_IMPORT = {
    ("cosim", "cargo-fmu"): "packs the FMUs that the tests run",
    ("cosim", "fmu-export"): "exports them",
}


def manifest(folder):
    return tomllib.loads((ROOT / folder / "Cargo.toml").read_text())


def layers():
    """{name of a crate: (its layer, its folder)}."""
    folders = [(product, f"{product}/{name}") for product, names in PRODUCTS.items() for name in names]
    folders += [("shells", name) for name in [*SHELLS, "actuator-table"]]
    folders += [("examples", folder) for folder in EXAMPLES]
    folders += [("studies", "python")]
    return {manifest(folder)["package"]["name"]: (layer, folder) for layer, folder in folders}


LAYERS = layers()


def imported(manifest, *kinds):
    """Crates of ours that the dependencies of these kinds name."""
    tables = [manifest, *manifest.get("target", {}).values()]
    names = {name for table in tables for kind in kinds for name in table.get(kind, {})}
    assert not any("package" in table[kind][name] for table in tables for kind in kinds for name in table.get(kind, {}) if name in LAYERS)
    return names & LAYERS.keys() - {manifest["package"]["name"]}


def allowed(name):
    layer = LAYERS[name][0]
    inside = [layer, *MAY_IMPORT[layer]]
    crates = {other for other, (of, folder) in LAYERS.items() if of in inside and folder not in (*SHELLS, *EXAMPLES)}
    return crates | {*AND_CRATES.get(layer, []), *AND_CRATES.get(name, []), *OF_MACHINE.get(name, [])}


@pytest.mark.parametrize("name", LAYERS)
def test_a_crate_imports_only_what_its_layer_may(name):
    found = manifest(LAYERS[name][1])
    wrong = imported(found, "dependencies", "build-dependencies") - allowed(name)
    assert wrong == set(), f"{name} ({LAYERS[name][0]}) must not import {sorted(wrong)}"
    for_tests = imported(found, "dev-dependencies") - allowed(name) - {of for crate, of in TESTS_MAY_IMPORT if crate == name}
    assert for_tests == set(), f"tests of {name} must not import {sorted(for_tests)}"


@pytest.mark.parametrize("name", OF_MACHINE)
def test_what_a_study_takes_of_the_machine_is_listed(name):
    machine = {crate for crate, (layer, _) in LAYERS.items() if layer == "machine"}
    found = imported(manifest(LAYERS[name][1]), "dependencies", "build-dependencies", "dev-dependencies")
    assert found & machine == set(OF_MACHINE[name])


def test_every_exception_is_needed():
    assert OF_MACHINE.keys() == {name for name, (layer, _) in LAYERS.items() if layer == "studies"}
    for crate, of in TESTS_MAY_IMPORT:
        assert of in imported(manifest(LAYERS[crate][1]), "dev-dependencies"), (crate, of)
    for crate in AND_CRATES.keys() & LAYERS.keys():
        assert set(AND_CRATES[crate]) <= imported(manifest(LAYERS[crate][1]), "dependencies"), crate


def rust_files(folder, *under):
    return [file for part in under or ("src", "tests", "benches") for file in (ROOT / folder / part).rglob("*.rs")]


def test_the_kits_solver_knows_no_fmi():
    files = rust_files("fmi/fmu-solver")
    assert files
    named = {str(file) for file in files if re.search(r"fmi", file.read_text(), re.IGNORECASE)}
    assert named == set()


def test_the_core_of_the_exporter_knows_no_version_of_fmi_and_no_webassembly():
    above = r"\bcrate::(border|check|fmi2|fmi3|wasm|model_description)"
    files = rust_files("kit/fmu-export", "src/core")
    assert files
    named = {str(file): found for file in files if (found := re.findall(above, stripped(file.read_text())))}
    assert named == {}


@pytest.mark.parametrize("name", PRODUCTS["machine"])
def test_the_machine_names_no_crate_of_fmi_kit_and_master(name):
    others = [crate for crate, (layer, _) in LAYERS.items() if layer in ("fmi", "kit", "master")]
    pattern = re.compile(rf"\b({'|'.join(others).replace('-', '[-_]')})\b")
    files = rust_files(f"machine/{name}")
    assert files
    named = {str(file): found for file in files if (found := pattern.findall(file.read_text()))}
    assert named == {}


@pytest.mark.parametrize("product", PRODUCTS)
def test_a_product_has_the_known_crates_and_says_what_it_is(product):
    tracked = subprocess.run(["git", "ls-files", product], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
    folders = {name.split("/")[1] for name in tracked if name.count("/") > 1}
    assert folders == {*PRODUCTS[product], *NO_CRATES.get(product, [])}
    assert (ROOT / product / "README.md").is_file()


def test_sources_have_one_style_of_modules_and_are_not_long():
    wrong = []
    for _, folder in LAYERS.values():
        for file in rust_files(folder, "src"):
            lines = len(file.read_text().splitlines())
            if file.name == "mod.rs":
                wrong.append(f"{file}: a module `name` is the file `name.rs`, with its children in `name/`")
            if lines > 600:
                wrong.append(f"{file}: {lines} lines, of at most 600")
    assert wrong == []


PUBLISHED = sorted(name for name, (_, folder) in LAYERS.items() if manifest(folder)["package"]["publish"] is True)


def test_the_crates_that_are_published_import_each_other_only():
    assert {"cargo-fmu", "fmi-description", "fmu-check", "fmu-export", "fmu-export-derive"} <= set(PUBLISHED)
    for name in PUBLISHED:
        assert imported(manifest(LAYERS[name][1]), "dependencies", "build-dependencies") <= set(PUBLISHED), name


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_published_crate_carries_the_licences(name):
    for licence in ("LICENSE-APACHE", "LICENSE-MIT"):
        copy = ROOT / LAYERS[name][1] / licence
        assert not copy.is_symlink() and copy.read_bytes() == (ROOT / licence).read_bytes(), f"{copy} is not the root's"


def test_no_symbolic_links_are_committed():
    """Windows checks them out as text files."""
    listed = subprocess.run(["git", "ls-files", "--stage"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert [line for line in listed.splitlines() if line.startswith("120000")] == []
