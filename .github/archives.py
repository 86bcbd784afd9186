"""What a release attaches, made of the folder of `cargo xtask dist`: archives, single files, checksums.

    python3 .github/archives.py target/dist 0.1.0 target/release-files
"""

import gzip
import hashlib
import io
import shutil
import sys
import tarfile
import zipfile
from pathlib import Path

#: Folders of programs, by platform.
PLATFORMS = ("linux64", "win64", "aarch64-linux")
#: The time of every entry, so that two archives of one folder are equal.
TIME = (2020, 1, 1, 0, 0, 0)


def files(folder):
    return sorted(path for path in folder.rglob("*") if path.is_file())


def write_tar(folder, name, path):
    """All of the folder, below a folder `name`; programs stay executable."""
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w") as archive:
        for file in files(folder):
            entry = tarfile.TarInfo(f"{name}/{file.relative_to(folder).as_posix()}")
            entry.size, entry.mode = file.stat().st_size, 0o755 if file.stat().st_mode & 0o100 else 0o644
            with file.open("rb") as content:
                archive.addfile(entry, content)
    path.write_bytes(gzip.compress(packed.getvalue(), mtime=0))


def write_zip(folder, name, path):
    """The same for Windows, without the programs of other platforms and their Python package."""
    others = {platform for platform in PLATFORMS if platform != "win64"} | {"python"}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in files(folder):
            inner = file.relative_to(folder)
            if inner.parts[0] not in others:
                archive.writestr(zipfile.ZipInfo(f"{name}/{inner.as_posix()}", TIME), file.read_bytes(), zipfile.ZIP_DEFLATED)


def main(folder, version, out):
    folder, out, name = Path(folder), Path(out), f"hdrm-fmu-{version}"
    wheels = sorted(folder.glob("python/*.whl"))
    single = [*sorted(folder.glob("*.fmu")), *sorted(folder.glob("*.ssp")), *sorted(folder.glob("*.html")), *sorted(folder.glob("*.wasm")), *wheels]
    if not (single and wheels):
        raise SystemExit(f"{folder} must hold FMUs and a wheel: make it with `cargo xtask dist`")
    out.mkdir(parents=True, exist_ok=True)
    write_tar(folder, name, out / f"{name}.tar.gz")
    write_zip(folder, name, out / f"{name}-win64.zip")
    for file in single:
        shutil.copy(file, out)
    for file in sorted(folder.glob("fmi3/*.fmu")):
        shutil.copy(file, out / f"fmi3-{file.name}")
    sums = [f"{hashlib.sha256(file.read_bytes()).hexdigest()}  {file.name}" for file in files(out) if file.name != "SHA256SUMS"]
    (out / "SHA256SUMS").write_text("\n".join(sums) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
