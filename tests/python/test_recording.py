"""Recordings, judged by readers of others: the mcap packages of PyPI. And what becomes of them when the process, the
disk or the reader of a pipe fails."""

import csv
import json
import os
import pathlib
import re
import resource
import runpy
import shutil
import signal
import socket
import struct
import subprocess
import sysconfig
import threading
import types

import pytest
from mcap.reader import NonSeekingReader, make_reader
from mcap_ros2.decoder import DecoderFactory

ROOT = pathlib.Path(__file__).resolve().parents[2]
BATON = pathlib.Path(os.environ.get("BATON", ROOT / "build" / "release" / "baton"))
WALK = ROOT / "examples" / "02_walk_and_turn.jsonl"
PERIOD = 0.005  # of mighty's ticks [s]

pytestmark = pytest.mark.skipif(not BATON.is_file(), reason=f"no program at {BATON}: make build, or set BATON")


def command(record, seconds, *more):
    world = [] if "--world" in more else ["--world", "flat"]
    drive = [BATON, "drive", *world, "--input", f"script:{WALK}", "--headless", "--record", record]
    return [str(part) for part in [*drive, "--seconds", seconds, *more]]


def drive(record, seconds, *more, **options):
    return subprocess.run(command(record, seconds, *more), capture_output=True, text=True, **options)


def baton(*args):
    return subprocess.run([BATON, *args], capture_output=True, text=True)


def messages(file, **which):
    """Topic, message and decoded content, in the order of the file; checksums are checked."""
    with open(file, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory(), Json()])
        for found in reader.iter_decoded_messages(**which):
            yield found.channel.topic, found.message, found.decoded_message


class Json:
    """Decodes what is in JSON, and holds it to its schema."""

    def decoder_for(self, encoding, schema):
        if encoding != "json":
            return None
        assert schema.encoding == "jsonschema"
        return lambda data: conforming(json.loads(data), json.loads(schema.data))


TYPES = {"object": dict, "array": list, "string": str, "integer": int, "number": (int, float), "boolean": bool, "null": type(None)}


def conforming(value, schema):
    """The value, if it is as JSON Schema says: types, required members, values, lengths, in what of it our schemas use."""
    types = schema.get("type", list(TYPES))
    types = [types] if isinstance(types, str) else types
    assert any(isinstance(value, TYPES[name]) for name in types), (value, schema)
    assert value in schema.get("enum", [value])
    if isinstance(value, dict):
        assert all(key in value for key in schema.get("required", ()))
        known = schema.get("properties")
        for key, member in value.items():
            assert known is None or key in known, f"{key} is not in the schema"
            conforming(member, (known or {}).get(key, {}))
    if isinstance(value, list):
        assert schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value))
        for member in value:
            conforming(member, schema.get("items", {}))
    return value


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Six seconds of a walk in physics: recording, trace, report."""
    folder = tmp_path_factory.mktemp("run")
    done = drive(folder / "run.mcap", 6, "--fast", "--seed", 3, "--trace", folder / "run.csv", "--report", folder / "run.json")
    assert done.returncode == 0, done.stderr
    return folder


def test_other_readers_find_every_message(run):
    with open(run / "run.mcap", "rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        header, summary = reader.get_header(), reader.get_summary()
        attachments = [attachment.name for attachment in reader.iter_attachments()]
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
    assert header.profile == "ros2" and header.library.startswith("baton ")
    assert attachments == ["profile.toml"]
    assert metadata["baton"]["robot"] == "mighty" and metadata["baton"]["seed"] == "3"
    counts, last = {}, 0
    for topic, message, _ in messages(run / "run.mcap"):
        counts[topic] = counts.get(topic, 0) + 1
        assert message.log_time == round(message.sequence * PERIOD * 1e9)
        last = message.log_time
    stated = summary.statistics.channel_message_counts
    assert counts == {channel.topic: stated[number] for number, channel in summary.channels.items() if stated[number]}
    assert sum(counts.values()) == summary.statistics.message_count
    assert summary.statistics.message_end_time == last == round(5.995e9)
    for topic in ("/joint_states", "/joint_targets", "/imu", "/sole/left", "/sole/right", "/baton/tick"):
        assert counts[topic] == 1200
    for topic in ("/baton/estimates", "/tf"):
        assert counts[topic] == 150
    assert counts["/baton/segments"] == json.loads((run / "run.json").read_text())["segments"]["committed"]
    with open(run / "run.mcap", "rb") as stream:
        assert sum(1 for _ in NonSeekingReader(stream, validate_crcs=True).iter_messages()) == sum(counts.values())


def test_the_index_leads_to_each_message(run):
    begin, end = round(2.1e9), round(2.3e9)
    found = [message.log_time for _, message, _ in messages(run / "run.mcap", topics=["/imu"], starting_at=begin, ending_before=end)]
    assert found == [round(tick * PERIOD * 1e9) for tick in range(420, 460)]
    with open(run / "run.mcap", "rb") as stream:
        reader = make_reader(stream)
        chunks = reader.get_summary().chunk_indexes
    # What is lost at most when the process is killed.
    assert all(chunk.message_end_time - chunk.message_start_time <= 0.08e9 for chunk in chunks)


def test_values_are_those_of_the_trace(run):
    with open(run / "run.csv") as lines:
        trace = list(csv.DictReader(lines))
    joints = [name.removeprefix("target_") for name in trace[0] if name.startswith("target_")]
    command = None
    for topic, message, content in messages(run / "run.mcap"):
        row = trace[message.sequence]
        assert abs(float(row["t"]) - 1e-9 * message.log_time) < 1e-6
        if topic == "/joint_targets":
            assert content.name == joints
            for joint, angle in zip(joints, content.position):
                assert abs(angle - float(row[f"target_{joint}"])) < 1e-6
        elif topic == "/joint_states":
            assert content.name == joints and len(content.velocity) == len(content.effort) == len(joints)
            measured = dict(zip(joints, content.position))
            assert all(abs(measured[joint] - float(row[f"target_{joint}"])) < 0.5 for joint in joints)
        elif topic == "/baton/command":
            command = content
        elif topic == "/baton/estimates":
            assert command["guide"] == row["guide"]
            assert content["phase"] == row["phase"] and content["segment"] == int(row["segment"])
            for axis, value, error in zip("xy", content["com"], content["dcm_error"]):
                assert abs(error - float(row[f"dcm_error_{axis}"])) < 1e-5
                assert abs(value - float(row[f"com_{axis}"])) < 0.05  # estimated; the trace has the true one
        elif topic == "/tf":
            (transform,) = content.transforms
            assert (transform.header.frame_id, transform.child_frame_id) == ("world", "root")
            root = transform.transform.translation
            assert abs(root.x - float(row["qpos_0"])) < 0.05 and abs(root.z - float(row["qpos_2"])) < 0.02
        elif topic == "/imu":
            q = content.orientation
            assert abs(q.x**2 + q.y**2 + q.z**2 + q.w**2 - 1) < 1e-9
    weight = [sum(c.wrench.force.z for t, m, c in messages(run / "run.mcap") if t.startswith("/sole/") and m.sequence == 10)]
    assert 30 < weight[0] < 70


def test_replay_info_and_export(run, tmp_path):
    again = baton("replay", run / "run.mcap", "--verify")
    assert again.returncode == 0 and "1200 ticks" in again.stdout and "identical bit for bit" in again.stdout
    info = baton("info", run / "run.mcap").stdout
    assert "mighty on sim in flat, seed 3" in info and "6.0 s, 1200 ticks" in info
    assert "finished" in info and "gaps      none" in info and len(info.splitlines()) < 45
    assert baton("export", run / "run.mcap", "--csv", tmp_path, "--plots", tmp_path).returncode == 0
    for name in ("joints", "torques", "balance", "imu", "stick"):
        assert (tmp_path / f"{name}.svg").read_text().endswith("</svg>\n")
    tables = {}
    for topic, message, content in messages(run / "run.mcap"):
        if topic in ("/joint_states", "/sole/left", "/baton/command"):
            tables.setdefault(topic, []).append((message.sequence, content))
    for topic, rows in tables.items():
        with open(tmp_path / (topic[1:].replace("/", "_") + ".csv")) as lines:
            table = list(csv.DictReader(lines))
        assert [int(row["tick"]) for row in table] == [tick for tick, _ in rows]
        for row, (_, content) in zip(table, rows):
            if topic == "/joint_states":
                assert all(float(row[f"position_{n}"]) == p for n, p in zip(content.name, content.position))
            elif topic == "/sole/left":
                assert float(row["force_z"]) == content.wrench.force.z
            else:
                assert row["guide"] == content["guide"] and float(row["axes_0"]) == content["axes"][0]
    # The trace of a replay is that of the run, but for what only the simulator knew.
    with open(run / "run.csv") as first, open(tmp_path / "trace.csv") as second:
        for there, here in zip(csv.DictReader(first), csv.DictReader(second), strict=True):
            assert all(here[name] in (value, "nan") for name, value in there.items())


def test_a_run_that_is_killed_leaves_a_file_that_opens(tmp_path):
    for attempt in range(4):
        record = tmp_path / f"{attempt}.mcap"
        with subprocess.Popen(command(record, 60, "--on", "ideal"), stdout=subprocess.DEVNULL) as process:
            while not record.exists() or record.stat().st_size < 60_000 + 15_000 * attempt:
                assert process.poll() is None
            process.send_signal(signal.SIGKILL)
        ticks = [message.sequence for topic, message, _ in messages(record) if topic == "/baton/tick"]
        assert len(ticks) > 20 and ticks == list(range(len(ticks)))
        again = baton("replay", record, "--verify")
        assert again.returncode == 0 and f"{len(ticks)} ticks" in again.stdout, again.stdout + again.stderr
        assert "not finished" in again.stdout and "not finished" in baton("info", record).stdout
        assert baton("export", record, "--csv", tmp_path / "csv").returncode == 0
        whole = tmp_path / "whole.mcap"
        assert baton("recover", record, "--out", whole).returncode == 0
        with open(whole, "rb") as stream:
            summary = make_reader(stream, validate_crcs=True).get_summary()
        copied = list(messages(whole))
        assert summary.statistics.message_count == len(copied)
        assert [(topic, message.log_time, message.data) for topic, message, _ in copied] == [
            (topic, message.log_time, message.data) for topic, message, _ in messages(record)
        ]
        again = baton("replay", whole, "--verify")
        assert again.returncode == 0 and f"{len(ticks)} ticks" in again.stdout and "not finished" not in again.stdout
        assert "the same file" in baton("recover", record, "--out", record).stderr


def test_a_kill_costs_at_most_the_last_tenth_of_a_second(tmp_path):
    """At a robot that knows which ticks there were, and when its driver is killed."""
    robot = runpy.run_path(str(ROOT / "examples" / "06_robot.py"))
    lost = []
    for at in range(100, 260, 16):  # at each place in a chunk of 16 ticks
        at += at // 16 % 16
        record = tmp_path / f"{at}.mcap"
        with socket.create_server(("127.0.0.1", 0)) as listener:
            on = f"tcp://127.0.0.1:{listener.getsockname()[1]}"
            driver = subprocess.Popen(command(record, 60, "--on", on, "--state", "torques"), stderr=subprocess.DEVNULL)
            connection = listener.accept()[0]

            def receive(connection, at=at, driver=driver, hear=robot["receive"]):
                kind, body = hear(connection)
                if kind == robot["TARGET"] and struct.unpack_from("<Q", body)[0] == at:
                    driver.kill()
                return kind, body

            scope = {**robot, "receive": receive}
            with pytest.raises(OSError):  # the driver is gone
                types.FunctionType(robot["serve"].__code__, scope)(connection)
            connection.close()
            driver.wait()
        ticks = [message.sequence for topic, message, _ in messages(record) if topic == "/baton/tick"]
        assert ticks == list(range(len(ticks)))
        lost.append(at + 1 - len(ticks))
    assert max(lost) * PERIOD <= 0.1, lost


def test_a_walk_takes_no_more_than_stated(tmp_path):
    done = drive(tmp_path / "walk.mcap", 18, "--fast")
    assert done.returncode == 0
    assert (tmp_path / "walk.mcap").stat().st_size / 18 < 150e3


def test_rerun_opens_it_with_all_its_channels(run, tmp_path):
    rerun = next(pathlib.Path(sysconfig.get_path("purelib")).glob("rerun_cli/rerun"))
    here = {**os.environ, "HOME": str(tmp_path)}

    def called(*args):
        return subprocess.run([rerun, *args], capture_output=True, text=True, env=here, timeout=120)

    converted = called("mcap", "convert", run / "run.mcap", "-o", tmp_path / "run.rrd")
    assert converted.returncode == 0, converted.stderr
    assert called("rrd", "verify", tmp_path / "run.rrd").returncode == 0
    stats = called("rrd", "stats", tmp_path / "run.rrd").stdout
    for topic in {topic for topic, _, _ in messages(run / "run.mcap")}:
        assert re.search(rf"^{topic}: ", stats, re.MULTILINE), topic


def test_a_replay_says_what_is_not_as_it_was(run, tmp_path):
    world = tmp_path / "plain.xml"
    shutil.copy(ROOT / "worlds" / "flat.xml", world)
    record = tmp_path / "run.mcap"
    assert drive(record, 1, "--fast", "--world", world).returncode == 0
    again = baton("replay", record, "--verify")
    assert again.returncode == 0 and again.stderr == ""
    world.write_text(world.read_text() + "<!-- another -->")
    again = baton("replay", record, "--verify")
    assert again.returncode == 0 and again.stderr.count("\n") == 1
    assert "the recording is of another world (checksum)" in again.stderr


def test_a_run_that_is_cut_anywhere_opens(run, tmp_path):
    whole = (run / "run.mcap").read_bytes()
    cut = tmp_path / "cut.mcap"
    before = -1
    for size in range(30_000, len(whole), 37_171):
        cut.write_bytes(whole[:size])
        again = baton("replay", cut, "--verify")
        assert again.returncode == 0, again.stderr
        ticks = int(again.stdout.split()[0])
        assert before <= ticks <= 1200
        before = ticks


def test_a_full_disk_costs_a_warning_and_the_rest_of_the_recording(tmp_path):
    report = tmp_path / "r.json"
    for limit in (0, 1000, 100_000, 300_000):
        record = tmp_path / f"{limit}.mcap"

        def full(limit=limit):
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

        options = ["--report", report] if limit > 50_000 else []
        done = drive(record, 4, "--fast", *options, preexec_fn=full)
        assert done.returncode == 0, done.stderr
        assert done.stderr.count("\n") == 1 and f"--record {record}: could not be written completely: File too large" in done.stderr
        assert "on its feet; the recording is not complete" in done.stdout
        if options:
            recording = json.loads(report.read_text())["recording"]
            assert recording["complete"] is False and "File too large" in recording["why"]
            ticks = [message.sequence for topic, message, _ in messages(record) if topic == "/baton/tick"]
            assert len(ticks) > limit / 1500
            again = baton("replay", record, "--verify")
            assert again.returncode == 0 and f"{len(ticks)} ticks" in again.stdout
    done = drive("/dev/full", 1, "--fast")
    assert done.returncode == 0 and "No space left on device" in done.stderr


def test_a_pipe_that_is_read_slowly_gets_everything(run, tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    alone = drive(pipe, 1, "--fast")
    assert alone.returncode == 2 and "it has no reader" in alone.stderr
    got = bytearray()
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    os.set_blocking(reader, True)

    def read():
        piece = b""
        while not got or piece:
            piece = os.read(reader, 501)
            got.extend(piece)

    thread = threading.Thread(target=read)
    done = subprocess.Popen(command(pipe, 6, "--fast", "--seed", 3), stdout=subprocess.DEVNULL)
    thread.start()
    assert done.wait() == 0
    thread.join()
    os.close(reader)
    assert bytes(got) == (run / "run.mcap").read_bytes()


def test_a_pipe_whose_reader_goes_costs_a_warning(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    process = subprocess.Popen(command(pipe, 4, "--fast"), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while True:
        try:
            if os.read(reader, 1000):
                break
        except BlockingIOError:
            pass
    os.close(reader)
    out, err = process.communicate()
    assert process.returncode == 0
    assert "Broken pipe" in err and err.count("\n") == 1 and "not complete" in out


def test_what_is_no_recording_is_one_line(tmp_path):
    old = tmp_path / "old.jsonl"
    old.write_text('{"baton_recording":2}\n')
    for args in (["replay", old], ["info", old], ["export", old, "--csv", tmp_path / "csv"]):
        done = baton(*args)
        assert done.returncode == 2 and "is not an MCAP file" in done.stderr and done.stderr.count("\n") == 1
    assert baton("export", old).returncode == 2
