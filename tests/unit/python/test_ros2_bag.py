"""Bags: readable at any time, split, and described as rosbag2 does. Read by two libraries that need no ROS."""

import errno
import os
import shutil
import struct

import pytest
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Message
from mcap.stream_reader import StreamReader
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import Reader

import camrig
from camrig.ros2 import bag as bags
from camrig.ros2 import messages
from camrig.ros2.bag import Bag, BagOptions, Topic
from camrig.ros2.camera_state import CameraState
from test_ros2_camera_state import reply

STATE = CameraState.of(reply())
TOPICS = [Topic("/tf_static", messages.TF, latched=True), Topic("/cam/image_raw/compressed", messages.COMPRESSED_IMAGE)]
PERIOD_NS = 40_000_000
ALWAYS = BagOptions(flush_s=0)


def open_bag(directory, options=ALWAYS):
    return Bag(directory, TOPICS, options, lambda log_ns: [("/tf_static", messages.optical_frames([STATE], log_ns))])


def write_frame(bag, n):
    stamp_ns = n * PERIOD_NS
    bag.write(TOPICS[1].name, stamp_ns, messages.compressed_image(STATE, stamp_ns, bytes([n % 256]) * (100 + n)))
    bag.end_of_instant()


def pictures(path):
    """Frame numbers of one file, every message decoded and its checksum checked."""
    numbers = []
    with open(path, "rb") as stream:
        for _, channel, message, decoded in make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            if channel.topic == TOPICS[1].name:
                stamp_ns = decoded.header.stamp.sec * 10**9 + decoded.header.stamp.nanosec
                assert message.log_time == message.publish_time == stamp_ns
                assert len(decoded.data) == 100 + stamp_ns // PERIOD_NS
                numbers.append(stamp_ns // PERIOD_NS)
    return numbers


def test_after_every_flush_the_bag_is_complete_for_all_readers(tmp_path):
    bag = open_bag(tmp_path / "bag")
    for n in range(1, 40):
        write_frame(bag, n)
        if n % 13 == 0:
            killed = tmp_path / f"killed_{n}"  # what a kill -9 would leave
            shutil.copytree(bag.directory, killed)
            assert pictures(killed / "bag_0.mcap") == list(range(1, n + 1))
            with Reader(killed) as reader:
                assert reader.message_count == n + 1 == sum(1 for _ in reader.messages())
    bag.close()
    assert pictures(tmp_path / "bag" / "bag_0.mcap") == list(range(1, 40))


def test_a_bag_without_a_message_opens(tmp_path):
    open_bag(tmp_path / "bag")
    with Reader(tmp_path / "bag") as reader:
        assert reader.message_count == 0
        assert {c.topic for c in reader.connections} == {topic.name for topic in TOPICS}


@pytest.mark.parametrize("cut", [1, 60, 150])
def test_what_was_flushed_before_is_readable_when_the_last_write_was_cut(tmp_path, cut):
    """The one moment without an index: the process dies inside the one write of a flush."""
    bag = open_bag(tmp_path / "bag", BagOptions(flush_s=3600))
    for n in range(1, 6):
        write_frame(bag, n)
    bag.flush()
    end_of_data = bag._files[0]._staged._start
    write_frame(bag, 6)
    bag.flush()
    path = tmp_path / "bag" / "bag_0.mcap"
    os.truncate(path, end_of_data + cut)
    found = []
    with open(path, "rb") as stream, pytest.raises((McapError, EOFError, struct.error)):
        for record in StreamReader(stream).records:
            if isinstance(record, Message):
                found.append(record.log_time // PERIOD_NS)
    assert found == [1, 1, 2, 3, 4, 5]  # the first is /tf_static


def test_files_are_split_where_an_instant_ends_and_each_stands_alone(tmp_path):
    bag = open_bag(tmp_path / "bag", BagOptions(flush_s=0, split_ns=10 * PERIOD_NS))
    for n in range(1, 26):
        write_frame(bag, n)
    bag.close()
    files = sorted((tmp_path / "bag").glob("*.mcap"))
    assert [pictures(path) for path in files] == [list(range(1, 12)), list(range(12, 23)), list(range(23, 26))]
    for path in files:
        with Reader(path) as reader:
            assert sum(c.msgcount for c in reader.connections if c.topic == "/tf_static") == 1
    with Reader(tmp_path / "bag") as reader:
        assert reader.message_count == 28 == sum(1 for _ in reader.messages())
        assert (reader.start_time, reader.duration) == (PERIOD_NS, 24 * PERIOD_NS + 1)


def test_a_split_at_the_very_end_leaves_no_empty_file(tmp_path):
    bag = open_bag(tmp_path / "bag", BagOptions(split_bytes=1))
    write_frame(bag, 1)
    bag.close()
    assert [path.name for path in (tmp_path / "bag").glob("*.mcap")] == ["bag_0.mcap"]
    with Reader(tmp_path / "bag") as reader:
        assert reader.message_count == 2


def test_memory_is_bounded_between_flushes(tmp_path):
    bag = open_bag(tmp_path / "bag", BagOptions(flush_s=3600, max_unflushed_bytes=1000))
    for n in range(1, 30):
        write_frame(bag, n)
    assert bag._unflushed < 1000
    assert len(pictures(tmp_path / "bag" / "bag_0.mcap")) > 15


def test_static_transforms_are_latched(tmp_path):
    bag = open_bag(tmp_path / "bag")
    write_frame(bag, 1)
    bag.close()
    with Reader(tmp_path / "bag") as reader:
        durability = {c.topic: c.ext.offered_qos_profiles[0].durability.name for c in reader.connections}
    assert durability == {"/tf_static": "TRANSIENT_LOCAL", "/cam/image_raw/compressed": "VOLATILE"}


def test_a_bag_overwrites_nothing(tmp_path):
    (tmp_path / "bag").mkdir()
    with pytest.raises(camrig.CamrigError) as caught:
        open_bag(tmp_path / "bag")
    assert caught.value.kind == "already_exists"


def test_the_profile_is_that_of_ros2(tmp_path):
    open_bag(tmp_path / "bag").close()
    with open(tmp_path / "bag" / "bag_0.mcap", "rb") as stream:
        assert make_reader(stream).get_header().profile == "ros2"
    assert bags._METADATA_VERSION == 5


@pytest.mark.parametrize("options", [ALWAYS, BagOptions(flush_s=1e9)])
def test_a_full_disk_leaves_what_was_flushed_before_and_says_so(tmp_path, monkeypatch, options):
    bag = open_bag(tmp_path / "bag", options)
    for n in range(1, 8):
        write_frame(bag, n)
    bag.flush()
    room = [300]  # bytes that the disk still takes beyond what the file has

    def pwrite(descriptor, data, offset, real=os.pwrite):
        left = os.fstat(descriptor).st_size + room[0] - offset
        if left <= 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        data = data[:left]
        room[0] -= max(0, offset + len(data) - os.fstat(descriptor).st_size)
        return real(descriptor, data, offset)

    monkeypatch.setattr(os, "pwrite", pwrite)
    with pytest.raises(camrig.CamrigError, match=r"bag_0.mcap: cannot be written: No space left on device; the bag holds what came before"):
        for n in range(8, 20):
            write_frame(bag, n)
        bag.flush()
    bag.close()
    held = pictures(bag.directory / "bag_0.mcap")
    assert held == list(range(1, len(held) + 1)) and 7 <= len(held) < 19
    with Reader(bag.directory) as reader:
        assert reader.message_count == len(held) + 1 == sum(1 for _ in reader.messages())
