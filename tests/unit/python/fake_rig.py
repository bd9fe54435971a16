"""A stand-in for the daemon: the control protocol over a Unix socket, TCP and HTTP, with answers made by the test.

Run as a program it plays `camrig serve` for the tests of camrig.start (see test_launch.py).
"""

from __future__ import annotations

import base64
import http.server
import json
import os
import socket
import socketserver
import threading
from typing import Any, Callable

import numpy as np


class Refuse(Exception):
    def __init__(self, kind: str | None, message: str, code: int = -32000) -> None:
        self.error: dict[str, Any] = {"code": code, "message": message}
        if kind:
            self.error["data"] = {"kind": kind}


class Vanish(Exception):
    """Closes the connection instead of an answer."""


class FakeRig:
    """Remembers each request; answers from `handlers`, or from the small world below."""

    def __init__(self) -> None:
        self.requests: list[tuple[str, dict[str, Any]]] = []
        self.handlers: dict[str, Callable[[dict[str, Any]], Any]] = {}
        self.cameras: dict[str, dict[str, Any]] = {}
        self.world_ns = 0
        self.picture = np.arange(6 * 4 * 4, dtype=np.uint8).reshape(4, 6, 4)  # 6x4 RGBA
        self.connections = 0

    def answer(self, line: bytes) -> bytes:
        request = json.loads(line)
        method, params = request["method"], request["params"]
        self.requests.append((method, params))
        reply: dict[str, Any] = {"jsonrpc": "2.0", "id": request["id"]}
        try:
            handler = self.handlers.get(method) or getattr(self, "do_" + method.replace(".", "_"), None)
            if handler is None:
                raise Refuse(None, f"no method {method}", -32601)
            reply["result"] = result = handler(params)
            if isinstance(result, dict) and result.get("encoding") == "bytes":
                reply["result"] = {key: value for key, value in result.items() if key != "data"}
                return json.dumps(reply).encode() + b"\n" + result["data"]
        except Refuse as refusal:
            reply["error"] = refusal.error
        return json.dumps(reply).encode() + b"\n"

    def do_server_info(self, params: dict[str, Any]) -> Any:
        return {"version": "0", "http": 8123, "rtsp": 8555}

    def do_camera_create(self, params: dict[str, Any]) -> Any:
        if params["name"] in self.cameras:
            raise Refuse("already_exists", f"camera '{params['name']}' exists already")
        self.cameras[params["name"]] = params
        return {**params, "applied_ns": self.world_ns}

    def do_camera_get(self, params: dict[str, Any]) -> Any:
        if params["name"] not in self.cameras:
            raise Refuse("not_found", f"no camera '{params['name']}'")
        return self.cameras[params["name"]]

    def do_camera_set(self, params: dict[str, Any]) -> Any:
        self.do_camera_get(params).update(params)
        return {"applied_ns": self.world_ns}

    def do_camera_delete(self, params: dict[str, Any]) -> Any:
        self.do_camera_get(params)
        del self.cameras[params["name"]]
        return {"applied_ns": self.world_ns}

    def do_camera_list(self, params: dict[str, Any]) -> Any:
        return {"cameras": list(self.cameras.values())}

    def do_world_step(self, params: dict[str, Any]) -> Any:
        self.world_ns += params["nanoseconds"] if "nanoseconds" in params else round(params["seconds"] * 1e9)
        return {"world_ns": self.world_ns}

    def do_frame_get(self, params: dict[str, Any]) -> Any:
        self.do_camera_get({"name": params["camera"]})
        data, height, width = self.picture.tobytes(), *self.picture.shape[:2]
        pixel_format = params.get("pixels", "rgba8")
        if pixel_format == "bgr24":
            data = self.picture[:, :, 2::-1].tobytes()
        if params["kind"] == "depth":
            data, pixel_format = np.full((height, width), np.inf, "<f4").tobytes(), "depth32f"
        elif params["kind"] != "color":
            raise Refuse("unsupported", f"frames of kind '{params['kind']}' are not built yet")
        elif params["format"] != "raw":
            import cv2

            suffix = {"png": ".png", "jpeg": ".jpg"}[params["format"]]
            data = cv2.imencode(suffix, np.ascontiguousarray(self.picture[:, :, 2::-1]))[1].tobytes()
        if params.get("encoding") == "bytes":
            encoded: dict[str, Any] = {"encoding": "bytes", "bytes": len(data), "data": data}
        else:
            encoded = {"encoding": "base64", "data": base64.b64encode(data).decode()}
        return {
            "camera": params["camera"],
            "sequence": 5,
            "time_ns": self.world_ns,
            "monotonic_ns": 1000 + self.world_ns,
            "size": [width, height],
            "kind": params["kind"],
            "format": params["format"],
            "pixels": pixel_format,
            **encoded,
        }


class _LineHandler(socketserver.StreamRequestHandler):
    def handle(self) -> None:
        rig: FakeRig = self.server.rig  # type: ignore[attr-defined]
        rig.connections += 1
        for line in self.rfile:
            try:
                self.wfile.write(rig.answer(line))
            except (OSError, Vanish):
                return


class _HttpHandler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["Content-Length"]))
        token = self.server.token  # type: ignore[attr-defined]
        if token and self.headers.get("Authorization") != f"Bearer {token}":
            self._send(401, b"{}")
        elif self.path != "/rpc":
            self._send(404, b"{}")
        else:
            self._send(200, self.server.rig.answer(body))  # type: ignore[attr-defined]

    def _send(self, status: int, body: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: Any) -> None:
        pass


class _UnixServer(socketserver.ThreadingMixIn, socketserver.UnixStreamServer):
    daemon_threads = True


class _TcpServer(socketserver.ThreadingTCPServer):
    daemon_threads = True
    address_family = socket.AF_INET


class _HttpServer(http.server.ThreadingHTTPServer):
    pass


def serve(server: socketserver.BaseServer, rig: FakeRig, token: str | None = None) -> socketserver.BaseServer:
    server.rig, server.token = rig, token  # type: ignore[attr-defined]
    threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
    return server


def serve_unix(rig: FakeRig, path: str) -> socketserver.BaseServer:
    return serve(_UnixServer(path, _LineHandler), rig)


def serve_tcp(rig: FakeRig) -> tuple[socketserver.BaseServer, int]:
    server = _TcpServer(("127.0.0.1", 0), _LineHandler)
    return serve(server, rig), server.server_address[1]


def serve_http(rig: FakeRig, token: str | None = None) -> tuple[socketserver.BaseServer, int]:
    server = _HttpServer(("127.0.0.1", 0), _HttpHandler)
    return serve(server, rig, token), server.server_address[1]


def main() -> None:
    """`fake serve SCENE ...`: the scene's name says how to behave."""
    import argparse
    import signal
    import sys

    parser = argparse.ArgumentParser()
    parser.add_argument("command")
    parser.add_argument("scene")
    for option in ("control", "http", "rtsp", "mode", "device", "seed", "token-file"):
        parser.add_argument(f"--{option}")
    parser.add_argument("--ready-fd", type=int)
    options = parser.parse_args()
    print("fake rig:", " ".join(sys.argv[1:]), file=sys.stderr, flush=True)
    if "broken" in options.scene:
        print("scenes/broken.json: cameras[0].size: is too small", file=sys.stderr, flush=True)
        sys.exit(1)
    if "silent" in options.scene:
        signal.pause()

    def end(*_: Any) -> None:
        if "crashing" in options.scene:
            print("CHECK failed: nothing is left", file=sys.stderr, flush=True)
            os.abort()
        os._exit(3 if "failing" in options.scene else 0)

    signal.signal(signal.SIGTERM, signal.SIG_IGN if "stubborn" in options.scene else end)
    rig = FakeRig()
    rig.handlers["server.info"] = lambda params: {"pid": os.getpid(), "arguments": sys.argv[1:]}
    serve_unix(rig, options.control)
    os.write(options.ready_fd, json.dumps({"control": options.control, "http": 8123, "rtsp": 8555}).encode() + b"\n")
    os.close(options.ready_fd)
    signal.pause()


if __name__ == "__main__":
    main()
