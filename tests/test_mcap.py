"""`hdrm-fmu run --mcap`, read back by `mcap` of PyPI: poses by the planar trigonometry of test_robot_files.py at the angles of the CSV file
of the same run, signals as there, times, findings."""

import csv
import json

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from native import call
from test_robot_files import UP, poses, whole

#: Communication points between rows, s.
INTERVAL = 0.02
COMPONENTS = {"controller", "emla_1", "emla_2", "emla_3", "hdrm"}


class Json:
    def decoder_for(self, encoding, schema):
        return json.loads if encoding == "json" and schema.encoding == "jsonschema" else None


def read(path):
    """By topic: schema, times in ns and decoded messages."""
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory(), Json()])
        summary, found = reader.get_summary(), {}
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            assert message.log_time == message.publish_time
            found.setdefault(channel.topic, (schema, [], []))[1].append(message.log_time)
            found[channel.topic][2].append(decoded)
    assert summary.chunk_indexes, "viewers find times by the index"
    assert summary.statistics.message_count == sum(len(times) for _, times, _ in found.values())
    return found


def run(folder, *options, seconds=0.5):
    files = folder / "run.mcap", folder / "run.csv"
    done = call("hdrm-fmu", "run", "--quiet", "--stop-time", seconds, "--set", "settle_time=0", "--mcap", files[0], "--csv", files[1], *options)
    return done, *files


def rows_of(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def placed(transform):
    """The pose as a matrix; quaternions by the formula of Rodrigues."""
    q, p, T = transform.rotation, transform.translation, np.eye(4)
    v = np.array([q.x, q.y, q.z])
    cross = np.cross(np.eye(3), v)
    T[:3, :3] = np.eye(3) + 2 * q.w * cross + 2 * cross @ cross
    T[:3, 3] = p.x, p.y, p.z
    return T


@pytest.mark.parametrize("name", ["reference", "hiab_xs031", "scaled"])
def test_poses_signals_and_times_are_those_of_the_run(tmp_path, name):
    done = call("hdrm-fmu", "machine", "scale", "--booms", "1.3", "--output", tmp_path / "scaled.json")
    assert done.returncode == 0, done.stderr
    machine = tmp_path / "scaled.json" if name == "scaled" else name
    done, recording, table = run(tmp_path, "--machine", machine, "--trajectory", "triangular", "--interval", INTERVAL)
    assert done.returncode == 0, done.stderr
    assert f"signals written to {recording}" in done.stdout
    machine, rows, topics = whole(tmp_path, name), rows_of(table), read(recording)
    times = [round(1e9 * float(row["time"])) for row in rows]
    assert len(times) == 26 and set(topics) == {"/tf", "/log", *(f"/{name}" for name in COMPONENTS)}
    schema, seen, transforms = topics["/tf"]
    assert (schema.name, schema.encoding, seen) == ("foxglove.FrameTransforms", "protobuf", times)
    moved = 0.0
    for row, t, message in zip(rows, times, transforms):
        found = {each.child_frame_id: placed(each) for each in message.transforms}
        assert {each.parent_frame_id for each in message.transforms} == {"world"}
        assert {each.timestamp.seconds * 10**9 + each.timestamp.nanos for each in message.transforms} == {t}
        expected, _ = poses(machine, [float(row[f"hdrm.zeta[{i}]"]) for i in range(1, 7)])
        tip = expected["D4"].copy()
        tip[:3, 3] += tip[:3, :3] @ machine["geometry"]["r_D4_T4"]
        expected["tip"] = tip
        assert set(found) == set(expected)
        for frame, T in expected.items():
            np.testing.assert_allclose(found[frame][:3], UP @ T[:3], rtol=0, atol=1e-9, err_msg=frame)
        moved = max(moved, np.abs(found["tip"] - placed(transforms[0].transforms[-1])).max())
    assert moved > 1e-3, "a machine at rest shows nothing"
    # Every column of the CSV file and no other, bit for bit, under its name and with its unit.
    units = {row["signal"]: row["unit"] for row in rows_of(table.with_suffix(".units.csv"))}
    compared = 0
    for component in COMPONENTS:
        schema, seen, messages = topics[f"/{component}"]
        assert (schema.name, schema.encoding, seen) == (component, "jsonschema", times)
        for row, message in zip(rows, messages):
            flat = dict(flatten(message, f"{component}", "", json.loads(schema.data), units))
            assert flat == {key: float(value) for key, value in row.items() if key.startswith(f"{component}.")}
            compared += len(flat)
    assert compared == len(rows) * (len(rows[0]) - 1)


def flatten(value, name, dot, schema, units):
    """Names and values of a message; the unit is what its schema says."""
    if isinstance(value, dict):
        assert schema["type"] == "object" and set(value) == set(schema["properties"])
        for key, part in value.items():
            yield from flatten(part, f"{name}.{key}", ".", schema["properties"][key], units)
    elif isinstance(value, list):
        assert schema["type"] == "array" and schema["items"] == {"type": "number"}
        for k, part in enumerate(value):
            assert units[f"{name}[{k + 1}]"] == schema["description"]
            yield f"{name}[{k + 1}]", part
    else:
        assert schema["type"] == "number" and units[name] == schema["description"]
        yield name, value


def test_findings_are_messages_at_the_end(tmp_path):
    done, recording, _ = run(tmp_path, "--max-error", "1e-9", "--interval", INTERVAL)
    assert done.returncode == 0 and "verdict: BAD" in done.stdout, done.stderr
    schema, times, messages = read(recording)["/log"]
    assert schema.name == "foxglove.Log" and set(times) == {500_000_000}
    told = [line.strip() for line in done.stdout.split("verdict: BAD\n")[1].splitlines() if line.startswith("  ")]
    level = {"!": 3, "-": 2}
    assert [(each.level, each.message) for each in messages] == [*((level[line[0]], line[2:]) for line in told), (2, "verdict: BAD")]
    assert any("tip error" in line for line in told) and {each.name for each in messages} == {"hdrm-fmu"}


def test_a_run_that_fails_keeps_its_rows_and_the_reason(tmp_path):
    done, recording, table = run(tmp_path, "--step", "0.01", seconds=5)
    assert done.returncode == 1 and f"are in `{recording}`" in done.stderr, done.stderr
    topics, rows = read(recording), rows_of(table)
    assert topics["/tf"][1] == [round(1e9 * float(row["time"])) for row in rows]
    [reason] = topics["/log"][2]
    assert reason.level == 4 and reason.message.split("\n")[0] in done.stderr


@pytest.mark.parametrize(
    "options, part",
    [
        (["--start-time", "-1"], "no time may be before 0 s"),
        (["--signals", "absent.*"], "absent.*"),
        (["--interval", "0.0015"], "multiple of the communication step"),
        (["--system", "Testbed.ssp"], "--mcap: "),
    ],
)
def test_what_cannot_be_recorded_is_refused_and_leaves_nothing(tmp_path, fmu_dir, options, part):
    options = [fmu_dir / option if option.endswith(".ssp") else option for option in options]
    done = call("hdrm-fmu", "run", "--quiet", "--stop-time", "0.01", "--mcap", tmp_path / "run.mcap", *options)
    assert done.returncode == 1 and part in done.stderr, done.stderr
    assert list(tmp_path.iterdir()) == []


def test_the_file_is_claimed_as_any_output(tmp_path):
    one = tmp_path / "one.csv"
    done = call("hdrm-fmu", "run", "--quiet", "--stop-time", "0.01", "--mcap", one, "--csv", one)
    assert done.returncode == 1 and "another output goes to the same file" in done.stderr
    missing = tmp_path / "absent" / "run.mcap"
    done = call("hdrm-fmu", "run", "--quiet", "--stop-time", "0.01", "--mcap", missing)
    assert done.returncode == 1 and "there is no folder" in done.stderr
    done = call("hdrm-fmu", "run", "--quiet", "--signals", "*")
    assert done.returncode == 2 and "--csv <FILE>|--mcap <FILE>" in done.stderr, done.stderr


def test_other_systems_and_all_signals(tmp_path, fmu_dir):
    """The machine as built, with everything that it has: text and truth values too."""
    done, recording, table = run(tmp_path, "--system", fmu_dir / "Real.ssp", "--signals", "*", "--interval", "0.01", seconds=0.05)
    assert done.returncode == 0, done.stderr
    topics, rows = read(recording), rows_of(table)
    assert {"/sensors", "/emla_1"} <= set(topics) and len(topics["/tf"][1]) == len(rows) == 6
    last = topics["/emla_1"][2][-1]
    assert last["F"] == float(rows[-1]["emla_1.F"])
