"""Packs a built library that uses `export_fmu!` into an FMU: python pack.py <library> <fmu>."""

import ctypes
import platform
import re
import sys
import zipfile
from pathlib import Path

RECEIVE = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p, ctypes.c_size_t)


def files(library):
    """All files of the FMU beside the binaries, as the library hands them out."""
    found, errors = {}, []

    def receive(_context, path, data, size):
        content = ctypes.string_at(data, size)
        if path is None:
            errors.append(content.decode())
        else:
            found[path.decode()] = content

    ctypes.CDLL(str(Path(library).resolve())).fmi2ExportFiles(None, RECEIVE(receive))
    if errors:
        sys.exit(f"{library}: {errors[0]}")
    return found


def pack(library, fmu):
    system = {"Linux": ("linux", ".so"), "Darwin": ("darwin", ".dylib"), "Windows": ("win", ".dll")}
    folder, ending = system[platform.system()]
    bits = 8 * ctypes.sizeof(ctypes.c_void_p)
    content = files(library)
    identifier = re.search(rb'modelIdentifier="(\w+)"', content["modelDescription.xml"])[1].decode()
    content[f"binaries/{folder}{bits}/{identifier}{ending}"] = Path(library).read_bytes()
    with zipfile.ZipFile(fmu, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in content.items():
            archive.writestr(path, data)


if __name__ == "__main__":
    pack(sys.argv[1], sys.argv[2])
