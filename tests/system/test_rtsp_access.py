"""Who may read: digest authentication for every method, RTSPS, multicast; never needed on loopback only."""

import socket

import cv2
import pytest

import camrig
from rtsp_client import RtspReader, gst_reads, run, take

TOKEN = "a-token-for-tests"


def ask(port, method, path="/main", head=""):
    """Status line and fields of one answer."""
    with socket.create_connection(("127.0.0.1", port), 20) as raw:
        url = "*" if method == "OPTIONS" and not path else f"rtsp://127.0.0.1:{port}{path}"
        raw.sendall(f"{method} {url} RTSP/1.0\r\nCSeq: 1\r\n{head}\r\n".encode())
        answer = b""
        while not answer.endswith(b"\r\n\r\n"):
            more = raw.recv(4096)
            if not more:
                break
            answer += more
        return answer.decode()


@pytest.fixture
def guarded(scenes, tmp_path):
    token_file = tmp_path / "token"
    token_file.write_text(TOKEN + "\n")
    with camrig.start(str(scenes / "minimal.json"), args=["--host", "0.0.0.0", "--token-file", str(token_file)]) as rig:
        yield rig, rig.call("server.info")["rtsp"]


METHODS = ["OPTIONS", "DESCRIBE", "SETUP", "PLAY", "PAUSE", "TEARDOWN", "GET_PARAMETER", "SET_PARAMETER", "ANNOUNCE", "RECORD"]


@pytest.mark.parametrize("method", METHODS)
def test_every_method_needs_credentials(guarded, method):
    _, port = guarded
    wrong = 'Authorization: Digest username="camrig", realm="GStreamer RTSP Server", nonce="0", uri="x", response="0"\r\n'
    basic = "Authorization: Basic Y2FtcmlnOmEtdG9rZW4tZm9yLXRlc3Rz\r\n"  # the right token, but in the clear
    for head in ("", wrong, basic):
        answer = ask(port, method, head="Transport: RTP/AVP/TCP;interleaved=0-1\r\n" + head)
        assert answer.startswith("RTSP/1.0 401 "), answer
        assert "WWW-Authenticate: Digest " in answer and "Basic" not in answer


def test_with_credentials_ffprobe_and_opencv_read_and_with_wrong_ones_they_do_not(guarded):
    _, port = guarded
    url = f"rtsp://camrig:{TOKEN}@127.0.0.1:{port}/main"
    done = run("ffprobe", "-v", "error", url)
    assert done.returncode == 0, done.stderr.decode()
    assert cv2.VideoCapture(url, cv2.CAP_FFMPEG).read()[0]
    assert len(take(RtspReader(url), 3)) == 3
    for bad in (f"rtsp://127.0.0.1:{port}/main", f"rtsp://camrig:wrong@127.0.0.1:{port}/main", f"rtsp://other:{TOKEN}@127.0.0.1:{port}/main"):
        done = run("ffprobe", "-v", "error", bad)
        assert done.returncode != 0 and b"401" in done.stderr


def test_beyond_loopback_a_token_is_asked_for(scenes):
    done = run("timeout", "20", camrig.launch.find_binary(), "serve", str(scenes / "minimal.json"), "--http", "0", "--rtsp", "0", "--host", "0.0.0.0")
    assert done.returncode == 1 and b"--token-file" in done.stderr


def test_a_taken_port_is_an_error_that_says_what_to_do(scenes, tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        done = run("timeout", "20", camrig.launch.find_binary(), "serve", str(scenes / "minimal.json"), "--control", str(tmp_path / "c"), "--http", "0",
                   "--rtsp", str(taken.getsockname()[1]))
    assert done.returncode == 1 and b"choose another --rtsp PORT" in done.stderr


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_on_loopback_nothing_is_asked(rig):
    assert ask(rig.call("server.info")["rtsp"], "OPTIONS").startswith("RTSP/1.0 200 OK")


def test_localhost_is_127_0_0_1(scenes):
    with camrig.start(str(scenes / "minimal.json"), args=["--host", "localhost"]) as rig:
        assert ask(rig.call("server.info")["rtsp"], "OPTIONS").startswith("RTSP/1.0 200 OK")


def test_rtsps_with_a_certificate(scenes, tmp_path):
    cert, key = tmp_path / "cert.pem", tmp_path / "key.pem"
    made = run("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost", "-keyout", str(key), "-out", str(cert))
    assert made.returncode == 0
    with camrig.start(str(scenes / "minimal.json"), args=["--rtsp-cert", str(cert), "--rtsp-key", str(key)]) as rig:
        port = rig.call("server.info")["rtsp"]
        done = run("ffprobe", "-v", "error", "-show_entries", "stream=codec_name", "-of", "csv=p=0", f"rtsps://127.0.0.1:{port}/main")
        assert done.returncode == 0 and done.stdout.strip() == b"h264", done.stderr.decode()
        assert rig.camera("main").url("rtsp") == f"rtsps://127.0.0.1:{port}/main"
        gst_reads(f"rtspsrc location=rtsps://127.0.0.1:{port}/main tls-validation-flags=0 latency=0 ! rtph264depay ! identity eos-after=5 ! fakesink")
        assert run("ffprobe", "-v", "error", "-timeout", "3000000", f"rtsp://127.0.0.1:{port}/main").returncode != 0  # in the clear: nothing


def test_multicast_is_offered_beyond_loopback_only(guarded, scenes):
    """Readers on the same machine get no multicast (docs/streams.md), so this asks for the transport only."""
    _, port = guarded
    reader = RtspReader.__new__(RtspReader)
    reader.url, reader.user, reader.password = f"rtsp://127.0.0.1:{port}/main", "camrig", TOKEN
    reader.socket, reader.data, reader.challenge, reader.session, reader.number = socket.create_connection(("127.0.0.1", port), 20), b"", None, None, 0
    reader.ask("DESCRIBE", reader.url, Accept="application/sdp")
    reader.ask("SETUP", reader.url + "/stream=0", Transport="RTP/AVP;multicast")
    assert reader.session
    with camrig.start(str(scenes / "minimal.json")) as rig:
        answer = ask(rig.call("server.info")["rtsp"], "SETUP", "/main/stream=0", head="Transport: RTP/AVP;multicast\r\n")
        assert answer.startswith("RTSP/1.0 461 "), answer
