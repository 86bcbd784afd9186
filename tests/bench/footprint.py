"""Size, load time and memory of each FMU: python tests/bench/footprint.py FMU_DIR (Linux)

Prints lines of JSON. Loading is the time from the unpacked file to the first initialized
instance; memory is what each further initialized instance adds to the process.
"""

import ctypes
import gc
import json
import sys
import tempfile
import time
import zipfile
from pathlib import Path
from xml.etree import ElementTree

INSTANCES = 200


class Callbacks(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in ("logger", "allocate", "free", "finished", "environment")]


def resident():
    """Memory of this process, bytes."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096


def instance(library, guid):
    library.fmi2Instantiate.restype = ctypes.c_void_p
    handle = library.fmi2Instantiate(b"one", 1, guid, None, ctypes.byref(CALLBACKS), 0, 0)
    assert handle, "fmi2Instantiate failed"
    for function in (library.fmi2EnterInitializationMode, library.fmi2ExitInitializationMode):
        assert function(ctypes.c_void_p(handle)) == 0
    return handle


CALLBACKS = Callbacks()


def main():
    for fmu in sorted(Path(sys.argv[1]).glob("*.fmu")):
        with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(fmu) as archive:
            archive.extractall(folder)
            guid = ElementTree.parse(Path(folder) / "modelDescription.xml").getroot().get("guid").encode()
            binary = next(Path(folder).glob("binaries/*/*"))
            start = time.perf_counter()
            library = ctypes.CDLL(str(binary))
            instance(library, guid)
            first = time.perf_counter()
            gc.collect()
            before = resident()
            for _ in range(INSTANCES):
                instance(library, guid)
            each = (time.perf_counter() - first) / INSTANCES
            memory = (resident() - before) / INSTANCES
            for name, unit, value in [
                ("packed", "kB", fmu.stat().st_size / 1e3),
                ("library", "kB", binary.stat().st_size / 1e3),
                ("loading to the first instance", "ms", 1e3 * (first - start)),
                ("each further instance", "ms", 1e3 * each),
                ("memory per instance", "kB", memory / 1e3),
            ]:
                value = round(value, 1)
                print(json.dumps({"name": f"{fmu.name}: {name}", "unit": unit, "median": value, "least": value}))


if __name__ == "__main__":
    main()
