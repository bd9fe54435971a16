"""The rig ends cleanly and in time, whatever it is doing. tests/attack does the same with more of everything."""

import contextlib
import json
import os
import pathlib
import signal
import socket
import subprocess
import threading
import time
import urllib.request

import camrig
from conftest import control_socket, stuck_mjpeg_reader, wait_until
from onvif_messages import SERVICES, SOAP
from ports import free_port
from rtsp_client import read_aside

#: Through this lens and from so far away the outline of everything in the hall is hard to follow.
HARD = {"lens": {"model": "rational_polynomial", "coefficients": [0.1, -0.2, 0, 0, 0.01, 0.3, -0.1, 0.02]}, "hfov_deg": 60,
        "position": (2, 1e5, 2.8), "orientation": (0, 0, 0, 1)}
TRUTHS = 200


def read_mjpeg(url):
    """A thread that takes all of a stream until its end, and the sizes of what it took."""
    taken = []

    def read():
        with urllib.request.urlopen(url, timeout=30) as stream:
            while chunk := stream.read1(1 << 16):
                taken.append(len(chunk))

    thread = threading.Thread(target=read, daemon=True)
    thread.start()
    return thread, taken


def test_a_rig_under_load_ends_within_five_seconds_of_sigterm(scenes):
    """Readers that read, one that is mute, one by RTSP, and truth that is dear. close() raises unless the exit code is 0 within 5 s."""
    with camrig.start(str(scenes / "hall.json"), mode="realtime") as rig:
        cam = rig.create_camera("busy", size=(1280, 720), fps=25, place="lobby")
        rig.create_camera("hard", size=(64, 48), **HARD)
        reading = [read_mjpeg(cam.url("mjpeg")) for _ in range(3)]
        mute = stuck_mjpeg_reader(cam)
        playing, pictures, _ = read_aside(cam.url("rtsp"))
        wait_until(lambda: pictures and all(len(taken) > 5 for _, taken in reading), what="pictures for everybody")
        asking = control_socket(rig)
        asking.sendall(b"".join(json.dumps({"jsonrpc": "2.0", "id": n, "method": "truth.get", "params": {"camera": "hard"}}).encode() + b"\n" for n in range(TRUTHS)))
        answers = asking.makefile("rb")
        assert "result" in json.loads(answers.readline())  # the others are under way
        rig.close()
        with mute, asking:
            try:
                answered = 1 + len(answers.readlines())
            except ConnectionError:
                answered = 1
        assert answered < TRUTHS, "all truth had been told before it was to end"
        for thread in (playing, *(thread for thread, _ in reading)):
            thread.join(10)
            assert not thread.is_alive(), "a reader was not told of the end"


def test_a_start_that_fails_says_why_whatever_is_in_work(tmp_path):
    """ONVIF answers already when the last port turns out to be taken; what the engine has in work for it then must find nobody gone."""
    port, is_over = free_port(), threading.Event()
    body = f'<e:Envelope xmlns:e="{SOAP}"><e:Body><GetProfiles xmlns="{SERVICES["trt"][0]}"/></e:Body></e:Envelope>'
    message = f"POST /onvif/device_service HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: {len(body)}\r\n\r\n{body}".encode()

    def ask(sent):
        while not is_over.is_set():
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), 1) as connection:
                for _ in range(50):
                    connection.sendall(message)
                    sent.append(1)

    sent = []
    asking = [threading.Thread(target=ask, args=(sent,)) for _ in range(4)]
    for thread in asking:
        thread.start()
    try:
        with socket.create_server(("127.0.0.1", 0)) as taken:
            number = 0
            while number < 5 or (not sent and number < 50):  # who asks beside it needs a moment to do so
                number += 1
                command = [camrig.launch.find_binary(), "serve", "minimal", "--http", "0", "--rtsp", "0", "--onvif", port, "--control", tmp_path / f"{number}.sock",
                           "--unrealcv", taken.getsockname()[1]]
                done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=30, check=False)
                assert done.returncode == 1 and "choose another --unrealcv PORT" in done.stderr, (done.returncode, done.stderr)
    finally:
        is_over.set()
        for thread in asking:
            thread.join()
    assert sent


def test_a_rig_that_is_started_right_behind_the_end_of_another_takes_its_place(tmp_path):
    # It waits for 3 s: on a busy machine the other may need longer for its end.
    assert any(place_is_taken(tmp_path / f"{number}.sock") for number in range(3)), "the second rig did not wait"


def place_is_taken(control):
    """Whether a rig waits for the end of another at the same socket, and then serves there."""
    serve = [camrig.launch.find_binary(), "serve", "minimal", "--http", "0", "--rtsp", "0", "--control", str(control)]
    first = subprocess.Popen(serve, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    second = None

    def who_answers():
        try:
            with camrig.connect(control) as rig:
                return rig.info()["pid"]
        except camrig.CamrigError:
            return None

    try:
        wait_until(lambda: who_answers() == first.pid, what="the first rig")
        first.send_signal(signal.SIGSTOP)  # it has the folder, and ends as soon as it may go on
        second = subprocess.Popen(serve, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        first.terminate()
        opened = lambda: {os.path.realpath(link) for link in pathlib.Path(f"/proc/{second.pid}/fd").iterdir()}
        wait_until(lambda: second.poll() is not None or f"{control}.d" in opened(), what="the second rig at the folder")
        time.sleep(0.3)  # it has found the folder taken, and waits
        first.send_signal(signal.SIGCONT)
        assert first.wait(20) == 0
        wait_until(lambda: second.poll() is not None or who_answers() == second.pid, what="the second rig")
        return second.poll() is None
    finally:
        for process in filter(None, (first, second)):
            process.send_signal(signal.SIGCONT)
            process.terminate()
            process.communicate(timeout=20)


def test_exec_says_that_there_is_no_rig_and_runs_the_program(tmp_path):
    done = subprocess.run([camrig.launch.find_binary(), "--control", tmp_path / "none.sock", "exec", "--", "echo", "ran"], capture_output=True, text=True, timeout=30)
    assert (done.returncode, done.stdout) == (0, "ran\n") and "no rig at" in done.stderr
    with camrig.start("minimal") as rig:
        done = subprocess.run([camrig.launch.find_binary(), "--control", rig.info()["control"], "exec", "--", "echo", "ran"], capture_output=True, text=True, timeout=30)
        assert (done.stdout, done.stderr) == ("ran\n", "")
