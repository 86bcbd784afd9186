"""`cargo fmu check` and `cosim` open archives alike: whatever the one refuses in an archive or its description fails the other."""

import io
import struct
import zipfile

import pytest

from native import call, cargo_fmu

XML = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="A" guid="{{1}}" {attributes}>
  <CoSimulation modelIdentifier="{identifier}"/>
  {vendor}
  <ModelVariables>
    <ScalarVariable name="y" valueReference="0" causality="output" variability="continuous"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="1"/></Outputs><InitialUnknowns><Unknown index="1"/></InitialUnknowns></ModelStructure>
</fmiModelDescription>
"""
LARGE = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="A" instantiationToken="1">
  <CoSimulation modelIdentifier="A"/>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <Float64 name="y" valueReference="1" causality="output"><Dimension start="3000"/><Dimension start="3000"/></Float64>
  </ModelVariables>
  <ModelStructure><Output valueReference="1"/><InitialUnknown valueReference="1"/></ModelStructure>
</fmiModelDescription>
"""


def xml(attributes="", identifier="A", vendor="", head=""):
    text = XML.format(attributes=attributes, identifier=identifier, vendor=vendor)
    return text.replace("<fmiModelDescription", head + "<fmiModelDescription", 1)


def packed(files, method=zipfile.ZIP_DEFLATED):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as archive:
        for name, content in files:
            archive.writestr(name, content)
    return bytearray(file.getvalue())


def sound(*further, description=None, method=zipfile.ZIP_DEFLATED):
    """An archive with only sources, which is never loaded."""
    return packed([("modelDescription.xml", description or xml()), ("sources/a.c", "int a;"), *further], method)


def link():
    info = zipfile.ZipInfo("resources/out")
    info.create_system, info.external_attr = 3, 0o120777 << 16
    return sound((info, "/etc"))


def changed(offset, value, of="resources/a"):
    """An archive whose directory says something else of a file: a field of its entry (APPNOTE, section 4.3.12)."""
    data = sound(("resources/a", b"text"))
    entry = data.rindex(b"PK\x01\x02", 0, data.rindex(of.encode()))
    struct.pack_into("<I" if offset in (20, 24, 42) else "<H", data, entry + offset, value)
    return data


def damaged():
    data = sound(("resources/a", b"text" * 100), method=zipfile.ZIP_STORED)
    data[data.index(b"text")] ^= 1
    return data


NESTED = "<VendorAnnotations><Tool name='a'>" + "<b>" * 300 + "</b>" * 300 + "</Tool></VendorAnnotations>"
BAD = {
    "text": lambda: b"text",
    "nothing": lambda: b"",
    "begins with something else": lambda: b"#!/bin/sh\n" + sound(),
    "cut off": lambda: sound()[:-30],
    "link": link,
    "two descriptions": lambda: sound(("modelDescription.xml", xml())),
    "one file by two names": lambda: sound(("resources/a", ""), ("./resources//a", "")),
    "up": lambda: sound(("../a", "")),
    "up inside": lambda: sound(("resources/../../a", "")),
    "root": lambda: sound(("/a", "")),
    "drive": lambda: sound(("C:/a", "")),
    "unpacks to 4 GB": lambda: changed(24, 0xFFFF_FFF0),
    "shares its bytes": lambda: changed(42, 0),
    "no description": lambda: packed([("sources/a.c", "")]),
    "nested": lambda: packed([("A/modelDescription.xml", xml()), ("A/sources/a.c", "")]),
    "empty description": lambda: packed([("modelDescription.xml", ""), ("sources/a.c", "")]),
    "no XML": lambda: sound(description="{}"),
    "another root": lambda: sound(description="<a/>"),
    "not closed": lambda: sound(description=xml().replace("</fmiModelDescription>", "")),
    "entities": lambda: sound(description=xml(head='<!DOCTYPE a [<!ENTITY b "c">]>')),
    "depth": lambda: sound(description=xml(vendor=NESTED)),
    "attributes": lambda: sound(description=xml(vendor="<VendorAnnotations>" + "<Tool " + " ".join(f'a{k}="1"' for k in range(300)) + "/></VendorAnnotations>")),
    "encoding": lambda: sound(description=xml().replace("UTF-8", "KOI8-R")),
    "no UTF-8": lambda: sound(description=xml().encode() + b"<!-- \xff\xfe -->"),
    "identifier": lambda: sound(description=xml(identifier="../A")),
    "9 000 000 elements": lambda: sound(description=LARGE),
    "damaged": lambda: packed([("modelDescription.xml", xml() + " " * 100)], zipfile.ZIP_STORED).replace(b"modelName", b"modelNam3", 1),
    "compression": lambda: sound(method=zipfile.ZIP_BZIP2),
    "encrypted": lambda: changed(8, 1, "modelDescription.xml"),
}


def run(tmp_path, data):
    (tmp_path / "A.fmu").write_bytes(data)
    info = call("cosim", "info", "A.fmu", cwd=tmp_path)
    return info, cargo_fmu("check", "A.fmu", cwd=tmp_path)


def test_the_sound_archive_passes_both(tmp_path):
    info, check = run(tmp_path, sound())
    assert info.returncode == 0, info.stderr
    assert check.returncode == 0, check.stdout + check.stderr


@pytest.mark.parametrize("what", BAD)
def test_what_cosim_refuses_fails_the_check(tmp_path, what):
    info, check = run(tmp_path, BAD[what]())
    assert info.returncode != 0, info.stdout
    assert check.returncode == 1 and "FAILS" in check.stdout, check.stdout + check.stderr
    # Whatever was asked for.
    only = cargo_fmu("check", "--only", "the library loads", "A.fmu", cwd=tmp_path)
    assert only.returncode != 0, only.stdout


@pytest.mark.parametrize("name", ["resources/CON", "resources/aux.txt", "resources/a?", "a./b", "resources/b ", "resources\\a"])
def test_names_that_windows_cannot_have_fail_everywhere(tmp_path, name):
    _, check = run(tmp_path, sound((name, "")))
    assert check.returncode == 1 and name.replace("\\", "/").split("/")[-1] in check.stdout, check.stdout


@pytest.mark.parametrize("words", [["--timeout", "0"], ["--only", "typo"], ["--only", ""]])
def test_options_that_select_nothing_are_refused(tmp_path, words):
    (tmp_path / "A.fmu").write_bytes(sound())
    done = cargo_fmu("check", *words, "A.fmu", cwd=tmp_path)
    assert done.returncode == 2 and words[0] in done.stderr and done.stdout == "", done.stderr
