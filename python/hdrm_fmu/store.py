"""The folder of a sweep: its options in `sweep.json`, a row for each case in Parquet files, and time series on request.

Rows are written in parts while the sweep runs, each part first under another name, so that no part is incomplete. At the end one file,
`results.parquet`, replaces the parts. Each Parquet file holds the SHA-256 of its bytes, so that a damaged one is not read.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
from pathlib import Path

import locket
import pandas
import pyarrow
from pyarrow import parquet

from hdrm_fmu.errors import BadInput

RESULTS = "results.parquet"
MANIFEST = "sweep.json"
#: Stands in a Parquet file's metadata, before the checksum, which is taken with zeros in its place.
MARK, ZEROS = b"hdrm_fmu.sha256=", b"0" * 64


def check_folder(folder, manifest):
    """Refuse a folder of another sweep, of another version, or with other files; it is left as it is."""
    folder = Path(folder)
    file = folder / MANIFEST
    if not file.exists():
        if folder.exists() and (not folder.is_dir() or any(path.name != ".lock" for path in folder.iterdir())):
            raise BadInput(f"{folder} holds other files; results must have a folder of their own")
        return
    try:
        there = json.loads(file.read_text())
    except (OSError, ValueError) as error:
        raise BadInput(f"{file} cannot be read: {error}") from None
    if not isinstance(there, dict):
        raise BadInput(f"{file} is damaged; put a copy in its place, or give a new folder")
    # The system last: its key also changes with the version and the schedule, which say more.
    for name in sorted({*there, *manifest}, key=lambda name: (name == "system", name)):
        old, new = there.get(name), manifest.get(name)
        if old != new:
            what = f"`{name}` is {old!r} there and {new!r} now"
            if name == "system":
                what = "the system, its parameter sets or its FMUs had other contents"
            raise BadInput(f"{folder} holds the results of another sweep: {what}; give a new folder")


class Store:
    """The results of a sweep, locked for as long as this is open."""

    def __init__(self, folder, manifest):
        self.folder = Path(folder)
        check_folder(folder, manifest)
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BadInput(f"{self.folder} cannot be made: {error.strerror}") from None
        self._lock = locket.lock_file(str(self.folder / ".lock"), timeout=0)
        try:
            self._lock.acquire()
        except locket.LockError:
            raise BadInput(f"another sweep is writing to {self.folder}") from None
        if not (self.folder / MANIFEST).exists():
            _whole(self.folder / MANIFEST, lambda path: path.write_text(json.dumps(manifest, indent=1, sort_keys=True)))
        self._pending = []

    def read(self):
        """All rows so far, by key."""
        return read_rows(self.folder)

    def _parts(self):
        return sorted(self.folder.glob("part-*.parquet"))

    def add(self, row, series=None):
        """Keep a row until the next `flush`; its time series (a Dataset) is written at once."""
        if series is not None:
            folder = self.folder / "series"
            folder.mkdir(exist_ok=True)
            table = series.to_dataframe().reset_index()
            _whole(folder / f"{row['key']}.parquet", lambda path: write_table(path, table))
        self._pending.append(row)

    def flush(self):
        """Write the pending rows."""
        if self._pending:
            frame = pandas.DataFrame(self._pending)
            name = f"part-{self._pending[0]['key']}.parquet"
            _whole(self.folder / name, lambda path: write_table(path, frame))
            self._pending = []

    @property
    def pending(self):
        """Number of rows that are not written yet."""
        return len(self._pending)

    def finish(self, frame, columns):
        """One file with all rows in place of the parts; rows of other cases that are there stay. Returns how many of them have the same values in
        the columns of cases, so that only their files can differ."""
        own = set(frame["key"])
        others = {key: row for key, row in self.read().items() if key not in own}
        cases = set(map(tuple, frame[columns].astype(str).values.tolist()))
        earlier = sum(tuple(str(row.get(name)) for name in columns) in cases for row in others.values())
        if others:
            frame = pandas.concat([frame, pandas.DataFrame(others.values())], ignore_index=True)
        _whole(self.folder / RESULTS, lambda path: write_table(path, frame))
        for part in self._parts():
            part.unlink()
        return earlier

    def close(self):
        """Write the pending rows, and unlock the folder."""
        self.flush()
        self._lock.release()


def read_rows(folder):
    """All rows in a folder, by key."""
    files = [path for path in [Path(folder) / RESULTS, *sorted(Path(folder).glob("part-*.parquet"))] if path.exists()]
    frames = [read_table(path).set_index("key", drop=False) for path in files]
    return {row["key"]: row for frame in frames for row in frame.to_dict("records")}


def _whole(path, write):
    """Write a file so that it is never seen incomplete."""
    path = path.resolve()
    new = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        write(new)
        os.replace(new, path)
    finally:
        new.unlink(missing_ok=True)


def write_table(path, frame):
    """Write a table as Parquet with its checksum."""
    table = pyarrow.Table.from_pandas(frame, preserve_index=False)
    written = io.BytesIO()
    parquet.write_table(table.replace_schema_metadata({**(table.schema.metadata or {}), b"hdrm_fmu": MARK + ZEROS}), written)
    data = written.getvalue()
    at = data.rfind(MARK + ZEROS) + len(MARK)
    path.write_bytes(data[:at] + hashlib.sha256(data).hexdigest().encode() + data[at + len(ZEROS) :])


def read_table(path):
    """Read a table that `write_table` wrote; one that is damaged is refused before anything in it is decoded."""
    data = path.read_bytes()
    found = data.rfind(MARK)
    at, end = found + len(MARK), found + len(MARK) + len(ZEROS)
    expected = hashlib.sha256(data[:at] + ZEROS + data[end:]).hexdigest().encode()
    if found < 0 or data[at:end] != expected:
        reason = "is damaged, or another program wrote it: its checksum is wrong"
        raise BadInput(f"`{path}` {reason}; put a copy in its place, or remove it to run its cases again")
    return pandas.read_parquet(io.BytesIO(data))
