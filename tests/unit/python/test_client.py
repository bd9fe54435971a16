"""The client against a stand-in for the daemon."""

import contextlib
import fcntl
import http.server
import json
import os
import signal
import socket
import threading
import time
from pathlib import Path

import pytest

import camrig
import fake_rig
from camrig.client import Client
from camrig.runtime import CommandKeyFile
from camrig.transport import LineConnection, unix_connector


def test_errors_carry_the_kind_and_message_of_the_rig(client_rig):
    client_rig.create_camera("lobby")
    with pytest.raises(camrig.CamrigError, match="exists already") as caught:
        client_rig.create_camera("lobby")
    assert caught.value.kind == "already_exists"
    with pytest.raises(camrig.CamrigError) as caught:
        client_rig.camera("nobody")
    assert caught.value.kind == "not_found"


def test_a_method_the_rig_does_not_know_is_unsupported(client_rig):
    with pytest.raises(camrig.CamrigError) as caught:
        client_rig.call("actor.fly", name="x")
    assert caught.value.kind == "unsupported"


def test_an_error_of_the_rig_keeps_the_connection(client_rig, fake):
    client_rig.info()
    before = fake.connections
    for _ in range(5):
        with pytest.raises(camrig.CamrigError):
            client_rig.camera("nobody")
    assert fake.connections == before


@pytest.mark.parametrize("answered", [None, 7000])
def test_what_answers_no_request_of_ours_is_an_error_and_ends_the_connection(client_rig, fake, monkeypatch, answered):
    """As a message that is too long is refused: without an id, and the rig closes behind it."""
    before, answer = fake.connections, fake.answer
    refusal = json.dumps({"jsonrpc": "2.0", "id": answered, "error": {"code": -32600, "message": "too long", "data": {"kind": "resource_exhausted"}}})
    monkeypatch.setattr(fake, "answer", lambda line: refusal.encode() + b"\n")
    with pytest.raises(camrig.CamrigError, match="7000" if answered else "too long") as caught:
        client_rig.info()
    assert caught.value.kind == ("internal" if answered else "resource_exhausted")
    monkeypatch.setattr(fake, "answer", answer)
    assert client_rig.info()["http"] == 8123
    assert fake.connections == before + 1


def test_no_rig_says_how_to_start_one(tmp_path):
    with pytest.raises(camrig.CamrigError, match="camrig serve") as caught:
        camrig.connect(tmp_path / "nothing.sock")
    assert caught.value.kind == "unavailable"


def test_a_rig_that_does_not_answer_is_a_timeout_and_the_next_call_is_in_step(client_rig, fake):
    gate = threading.Event()
    fake.handlers["slow"] = lambda params: gate.wait(10) and "late"
    with pytest.raises(camrig.CamrigTimeout) as caught:
        client_rig.client.call("slow", timeout_s=0.05)
    assert caught.value.kind == "unavailable"
    assert isinstance(caught.value, TimeoutError)
    gate.set()
    assert client_rig.call("server.info")["http"] == 8123


@pytest.mark.parametrize("long", [float("inf"), 1e10])
def test_a_timeout_may_be_as_long_as_one_likes(client_rig, tmp_path, long):
    assert client_rig.client.call("server.info", timeout_s=long)["http"] == 8123
    camrig.connect(tmp_path / "control.sock", timeout=long).close()


def test_a_timeout_that_is_no_number_is_over_at_once(client_rig):
    with pytest.raises(camrig.CamrigTimeout):
        client_rig.client.call("server.info", timeout_s=float("nan"))


def test_a_closed_connection_is_opened_again(tmp_path):
    path = str(tmp_path / "socket")
    first = fake_rig.serve_unix(fake_rig.FakeRig(), path)
    client = Client(unix_connector(path))
    client.call("server.info")
    first.shutdown()
    first.server_close()
    (tmp_path / "socket").unlink()
    for connection in client._idle:  # what the kernel does when the daemon dies
        connection._socket.shutdown(2)
    second = fake_rig.FakeRig()
    server = fake_rig.serve_unix(second, path)
    client.call("server.info")
    assert [method for method, _ in second.requests] == ["server.info"]
    client.close()
    server.shutdown()
    server.server_close()


def test_a_request_is_never_sent_twice(client_rig, fake):
    def vanish(params):
        raise fake_rig.Vanish

    fake.handlers["camera.create"] = vanish
    with pytest.raises(camrig.CamrigError) as caught:
        client_rig.create_camera("lobby")
    assert caught.value.kind == "unavailable"
    assert len(fake.requests) == 1


def test_threads_do_not_wait_for_each_other(client_rig, fake):
    both = threading.Barrier(2, timeout=5)
    fake.handlers["meet"] = lambda params: both.wait() is not None
    results = []
    threads = [threading.Thread(target=lambda: results.append(client_rig.call("meet"))) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [True, True]


def test_many_threads_get_their_own_answers(client_rig, fake):
    fake.handlers["echo"] = lambda params: params["value"]
    wrong = []

    def work(base):
        for i in range(50):
            if client_rig.call("echo", value=base + i) != base + i:
                wrong.append(base + i)

    threads = [threading.Thread(target=work, args=(1000 * t,)) for t in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def is_true_in_a_forked_process(work):
    """False too where it hangs."""
    child = os.fork()
    if child == 0:
        answer = False
        try:
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            signal.alarm(20)
            answer = work()
        finally:
            os._exit(not answer)
    return os.waitpid(child, 0)[1] == 0


def test_a_forked_process_opens_connections_of_its_own(client_rig, fake):
    before = fake.connections
    assert len(client_rig.client._idle) == 1
    assert is_true_in_a_forked_process(lambda: client_rig.info()["http"] == 8123)
    assert fake.connections == before + 1
    client_rig.info()
    assert fake.connections == before + 1, "that of the parent is as it was"


def test_a_fork_while_another_thread_holds_the_lock_does_not_stop_the_forked_process(client_rig):
    with client_rig.client._lock:
        assert is_true_in_a_forked_process(lambda: client_rig.info()["http"] == 8123)


def test_what_is_not_json_is_refused_before_it_is_sent(client_rig, fake):
    with pytest.raises(camrig.CamrigError) as caught:
        client_rig.call("camera.set", name="x", near=float("nan"))
    assert caught.value.kind == "invalid_argument"
    assert not fake.requests


def test_control_over_tcp_gives_its_token_first():
    fake = fake_rig.FakeRig()
    fake.handlers["auth"] = lambda params: {"ok": params["token"]}
    server, port = fake_rig.serve_tcp(fake)
    with camrig.connect(host="127.0.0.1", port=port, token="secret-token") as rig:
        assert rig.cameras() == []
        assert rig.http_url == "http://127.0.0.1:8123"
    assert fake.requests[0] == ("auth", {"token": "secret-token"})
    assert [method for method, _ in fake.requests].count("auth") == 1
    server.shutdown()
    server.server_close()


def test_a_rig_that_does_not_answer_the_token_is_a_timeout_too():
    fake, gate = fake_rig.FakeRig(), threading.Event()
    fake.handlers["auth"] = lambda params: gate.wait(10)
    server, port = fake_rig.serve_tcp(fake)
    with pytest.raises(camrig.CamrigTimeout, match="auth: no answer within 0.2 s"):
        camrig.connect(host="127.0.0.1", port=port, token="secret-token", timeout=0.2)
    gate.set()
    server.shutdown()
    server.server_close()


@contextlib.contextmanager
def deaf_address():
    """Where nobody answers: a listener that takes nobody, and has as many who wait as it can have."""
    with contextlib.ExitStack() as stack:
        listener = stack.enter_context(socket.create_server(("127.0.0.1", 0), backlog=0))
        for _ in range(3):
            waiting = stack.enter_context(socket.socket())
            waiting.setblocking(False)
            waiting.connect_ex(listener.getsockname())
        yield listener.getsockname()


@pytest.mark.parametrize("way", ["port", "http_port"])
def test_a_host_of_many_addresses_has_one_time_out(monkeypatch, way):
    def resolve_to(*addresses):
        monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: [(socket.AF_INET, socket.SOCK_STREAM, 0, "", address) for address in addresses])

    fake = fake_rig.FakeRig()
    server, port = fake_rig.serve_tcp(fake) if way == "port" else fake_rig.serve_http(fake)
    with deaf_address() as deaf:
        resolve_to(deaf, deaf, deaf, deaf)
        begin = time.monotonic()
        with pytest.raises(camrig.CamrigTimeout, match=f"rig.example:{port} does not answer") as caught:
            camrig.connect(host="rig.example", **{way: port}, timeout=0.5)
        assert caught.value.kind == "unavailable" and time.monotonic() - begin < 1.5
        # One that answers is found behind one that does not.
        resolve_to(deaf, ("127.0.0.1", port))
        with camrig.connect(host="rig.example", **{way: port}, timeout=2) as rig:
            assert rig.info()["http"] == 8123
    server.shutdown()
    server.server_close()


def test_control_over_http():
    fake = fake_rig.FakeRig()
    server, port = fake_rig.serve_http(fake, token="secret-token")
    with camrig.connect(host="127.0.0.1", http_port=port, token="secret-token") as rig:
        rig.create_camera("lobby")
        assert [camera.name for camera in rig.cameras()] == ["lobby"]
    with pytest.raises(camrig.CamrigError) as caught:
        camrig.connect(host="127.0.0.1", http_port=port, token="wrong-token")
    assert caught.value.kind == "unauthorized"
    server.shutdown()
    server.server_close()


def test_a_closed_rig_says_so(client_rig):
    client_rig.close()
    with pytest.raises(camrig.CamrigError, match="closed"):
        client_rig.info()


@pytest.fixture
def keys(tmp_path, monkeypatch):
    """This user's folder of keys."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    (tmp_path / "camrig").mkdir(mode=0o700)
    return tmp_path / "camrig"


def test_the_key_of_a_rig_of_this_user_is_found_by_its_address(keys):
    fake = fake_rig.FakeRig()
    fake.handlers["auth"] = lambda params: {"authorized": True}
    http, http_port = fake_rig.serve_http(fake, "the-key")
    tcp, tcp_port = fake_rig.serve_tcp(fake)
    of_http, of_tcp = CommandKeyFile("the-key", "127.0.0.1", http_port), CommandKeyFile("another-key", "127.0.0.1", tcp_port)
    camrig.connect(f"http://127.0.0.1:{http_port}").close()
    camrig.connect(host="localhost", port=tcp_port).close()
    assert ("auth", {"token": "another-key"}) in fake.requests
    (keys / f"127.0.0.1:{http_port}.key").rename(keys / f"[::1]:{http_port}.key")
    with pytest.raises(camrig.CamrigError, match="refused the token"):
        camrig.connect(host="127.0.0.1", http_port=http_port)
    camrig.connect(f"http://127.0.0.1:{http_port}/#key=the-key").close()
    of_tcp.close()
    of_http.close()
    assert [path.name for path in keys.iterdir()] == [f"[::1]:{http_port}.key"]
    for server in (http, tcp):
        server.shutdown()
        server.server_close()


@pytest.mark.parametrize("planted", ["folder open to all", "link", "left by a rig that was killed"])
def test_a_key_that_no_rig_of_this_user_holds_is_not_shown(keys, planted):
    fake = fake_rig.FakeRig()
    server, port = fake_rig.serve_tcp(fake)
    key = keys / f"127.0.0.1:{port}.key"
    if planted == "link":
        (keys / "elsewhere").write_text("planted")
        key.symlink_to(keys / "elsewhere")
    else:
        key.write_text("planted")
    with key.open() as planter:
        if planted != "left by a rig that was killed":
            fcntl.flock(planter, fcntl.LOCK_EX)
        if planted == "folder open to all":
            keys.chmod(0o755)
        camrig.connect(host="127.0.0.1", port=port).close()
    assert [method for method, _ in fake.requests] == ["server.info"]
    keys.chmod(0o700)
    CommandKeyFile("new", "127.0.0.1", 1).close()
    assert key.exists() == (planted == "link")
    server.shutdown()
    server.server_close()


def test_an_address_is_taken_as_on_the_command_line_given_or_in_the_environment(monkeypatch):
    fake = fake_rig.FakeRig()
    tcp, tcp_port = fake_rig.serve_tcp(fake)
    http, http_port = fake_rig.serve_http(fake)
    for address in (f"127.0.0.1:{tcp_port}", f"[127.0.0.1]:{tcp_port}", f"http://127.0.0.1:{http_port}"):
        camrig.connect(address).close()
        monkeypatch.setenv("CAMRIG_CONTROL", address)
        camrig.connect().close()
    assert len(fake.requests) == 6
    with camrig.connect(host="127.0.0.1", port=tcp_port) as rig:
        assert rig.control == f"127.0.0.1:{tcp_port}", "what was told goes before the environment"
    for server in (tcp, http):
        server.shutdown()
        server.server_close()


def test_a_path_object_with_a_colon_is_a_path_and_so_is_text_with_a_slash(tmp_path, monkeypatch):
    fake = fake_rig.FakeRig()
    server = fake_rig.serve_unix(fake, str(tmp_path / "a:1"))
    monkeypatch.chdir(tmp_path)
    for control in (Path("a:1"), "./a:1"):
        camrig.connect(control).close()
    server.shutdown()
    server.server_close()


@pytest.mark.parametrize(
    "wrong",
    [
        {"control": "/run/a.sock", "http_port": 8080},
        {"control": "/run/a.sock", "port": 9000},
        {"control": Path("/run/a.sock"), "host": "127.0.0.1", "port": 9000},
        {"control": "127.0.0.1:9000", "http_port": 8080},
        {"port": 9000, "http_port": 8080},
        {"host": "127.0.0.1", "port": 9000, "http_port": 8080},
        {"host": "127.0.0.1"},
    ],
)
def test_two_places_of_one_rig_or_half_of_one_are_an_error(wrong):
    with pytest.raises(camrig.CamrigError, match="give control, or host with either port .TCP. or http_port") as refused:
        camrig.connect(**wrong)
    assert refused.value.kind == "invalid_argument"


@pytest.mark.parametrize("address", ["host:", ":80", "host:port", "host:0", "host:99999", "host:+8", "http://", "http://:80", "http://127.0.0.1:99999", "http://127.0.0.1:80/cameras"])
def test_an_address_that_is_none_is_said_to_be(address):
    with pytest.raises(camrig.CamrigError) as refused:
        camrig.connect(address)
    assert refused.value.kind == "invalid_argument"


def test_bytes_behind_an_answer_are_taken_whole_however_they_come():
    ours, rigs = socket.socketpair()
    connection, deadline = LineConnection(ours), time.monotonic() + 20
    picture = bytes(range(256)) * 50

    def serve():
        for cut in (0, 1, 7000):
            rigs.recv(100)
            rigs.sendall(b'{"bytes": 12800}\n' + picture[:cut])
            for begin in range(cut, len(picture), 3000):
                rigs.sendall(picture[begin : begin + min(3000, len(picture) - begin)])
        rigs.recv(100)
        rigs.sendall(b"{}\nmore")

    thread = threading.Thread(target=serve)
    thread.start()
    for _ in range(3):
        assert connection.roundtrip(b"ask", deadline) == b'{"bytes": 12800}'
        assert connection.read_bytes(12800, deadline) == picture
        assert connection.is_idle()
    # What nobody asked for is no answer to the next request.
    assert connection.roundtrip(b"ask", deadline) == b"{}"
    assert not connection.is_idle()
    thread.join()
    connection.close()
    rigs.close()


def test_what_the_rig_said_before_it_closed_is_told_though_nothing_can_be_sent_any_more():
    ours, rigs = socket.socketpair()
    connection = LineConnection(ours)
    rigs.sendall(b'{"error": "too many"}\n')
    rigs.close()
    assert connection.roundtrip(b"ask", time.monotonic() + 20) == b'{"error": "too many"}'
    with pytest.raises(BrokenPipeError):
        connection.roundtrip(b"ask", time.monotonic() + 20)
    connection.close()


@pytest.mark.parametrize("head", [b"", b"HTTP/1.1 200 OK\r\nContent-Type: application/json\r\nContent-Length: 1000\r\n\r\n"])
def test_over_http_a_call_ends_in_time_however_slowly_its_answer_comes(head):
    listener = socket.create_server(("127.0.0.1", 0))

    def answer():
        connection, _ = listener.accept()
        with connection, contextlib.suppress(OSError):
            connection.recv(1000)
            connection.sendall(head)
            for _ in range(50):
                connection.sendall(b"H")
                time.sleep(0.1)

    thread = threading.Thread(target=answer)
    thread.start()
    begin = time.monotonic()
    with pytest.raises(camrig.CamrigTimeout):
        camrig.connect(host="127.0.0.1", http_port=listener.getsockname()[1], timeout=0.5)
    assert time.monotonic() - begin < 3
    thread.join()
    listener.close()


def test_a_refusal_by_http_keeps_its_reason_and_kind():
    answers = [(403, {"error": {"message": "Host 'mybox' is not this server's"}}), (503, {"error": {"kind": "resource_exhausted", "message": "too many clients"}}), (401, None)]

    class Refuses(http.server.BaseHTTPRequestHandler):
        def do_POST(self):
            self.rfile.read(int(self.headers["Content-Length"]))
            status, told = answers.pop(0)
            body = json.dumps(told).encode()
            self.send_response(status)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_):
            pass

    with http.server.HTTPServer(("127.0.0.1", 0), Refuses) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        for kind, words in (("unauthorized", "Host 'mybox'"), ("resource_exhausted", "too many clients"), ("unauthorized", "refused the token")):
            with pytest.raises(camrig.CamrigError, match=words) as refused:
                camrig.connect(f"http://127.0.0.1:{server.server_port}")
            assert refused.value.kind == kind
        server.shutdown()
