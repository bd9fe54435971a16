"""A rig's MJPEG stream as `camrig ros2 record` reads it."""

import http.server
import threading

import pytest

from camrig import CamrigError
from camrig.ros2.mjpeg import MjpegStream

PART = b"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: 4\r\nX-Sequence: 7\r\nX-World-Time-Ns: 40\r\nX-Monotonic-Ns: 50\r\n\r\njpeg\r\n--frame--\r\n"


@pytest.fixture
def door():
    """A server that answers by path: with a stream, or with 307 and the place that `moved` has for it."""

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            asked.append(self.path)
            to = moved.get(self.path.partition("?")[0])
            self.send_response(307 if to is not None else 200)
            if to is not None:
                self.send_header("Location", to.format(own=own))
                self.send_header("Content-Length", "0")
            self.end_headers()
            self.wfile.write(b"" if to is not None else PART)

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
    own, asked, moved = f"http://127.0.0.1:{server.server_address[1]}", [], {}
    yield own, asked, moved
    server.shutdown()
    server.server_close()


def test_a_farms_door_sends_the_reader_to_the_cameras_node(door):
    """What is asked there is what the door says, and nothing of ours."""
    own, asked, moved = door
    moved.update({"/eye": "{own}/node?quality=90", "/near": "/node"})
    for path in ("/eye?quality=90&token=secret", "/near?token=secret"):
        stream = MjpegStream("eye", f"{own}{path}")
        frame = stream.next()
        assert (frame.sequence, frame.world_ns, frame.monotonic_ns, frame.jpeg) == (7, 40, 50, b"jpeg") and stream.next() is None
        stream.close()
    assert asked == ["/eye?quality=90&token=secret", "/node?quality=90", "/near?token=secret", "/node"]


@pytest.mark.parametrize("to", ["{own}/eye", "https://127.0.0.1/eye?token=secret", "http://127.0.0.1:port/", ""])
def test_who_is_sent_on_and_on_or_elsewhere_than_to_http_is_told(door, to):
    own, asked, moved = door
    moved["/eye"] = to
    with pytest.raises(CamrigError, match="camera eye: ") as refused:
        MjpegStream("eye", f"{own}/eye?token=secret")
    assert refused.value.kind == "unavailable" and "secret" not in refused.value.message and len(asked) <= 2
