"""A running rig."""

from __future__ import annotations

import os
import re
import urllib.parse
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Mapping, Protocol, Sequence

from .camera import Camera
from .client import DEFAULT_TIMEOUT_S, Client
from .errors import CamrigError
from .fault import Faults
from .grab import Instant, grab
from .network import Network
from .places import find_binary
from .recording import record, record_options
from .spec import camera_params, step_params, takes_camera_options
from .transport import http_connector, tcp_connector, unix_connector

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .parameters import Action, ActorChanges, ActorOptions, CameraOptions, Steering, Trigger


class Owner(Protocol):
    """What keeps the rig running: the process that start() made."""

    def stop(self) -> None:
        """Raises CamrigError when the rig did not end as it should."""

    @property
    def log(self) -> str: ...


class Rig:
    """A connection to a rig; any thread may use it. As a context manager it closes, and stops a rig that it started."""

    def __init__(
        self,
        client: Client,
        *,
        control: str | None = None,
        host: str | None = None,
        token: str | None = None,
        ports: dict[str, int] | None = None,
        owner: Owner | None = None,
        program: str | None = None,
    ) -> None:
        """control: where the command line finds this rig, a path or HOST:PORT; None when it cannot. program: the camrig that runs it, if we know."""
        self.client = client
        self._control = control
        self.token = token
        self._host = host
        self._ports = ports
        self._owner = owner
        self._program = program

    # Cameras

    @takes_camera_options
    def create_camera(self, name: str, *, place: str | None = None, **options: Unpack[CameraOptions]) -> Camera:
        """Makes a camera. All options may be left out; camrig.parameters.CameraOptions and docs/control-protocol.md say what each means.

        place is one of the scene's: it gives pose and field of view. fps also as Fraction; intrinsics also as 3x3 matrix; mount also as "ACTOR"
        or "ACTOR/NODE"; lens also as (model, coefficients); outputs also by their kind alone: ["mjpeg"].
        """
        params = camera_params(**options)
        if place is not None:
            params["place"] = place
        self.call("camera.create", name=name, **params)
        return Camera(self, name)

    def camera(self, name: str) -> Camera:
        """A camera that exists, else CamrigError of kind not_found."""
        self.call("camera.get", name=name)
        return Camera(self, name)

    def cameras(self) -> list[Camera]:
        reply = self.call("camera.list")
        items = reply.get("cameras", []) if isinstance(reply, dict) else reply
        return [Camera(self, item if isinstance(item, str) else item["name"]) for item in items]

    def grab(self, cameras: Sequence[Camera | str] = (), kinds: Sequence[str] = ("color",), *, timeout: float = 20.0) -> Instant:
        """Pictures and truth of these cameras (none: all), all of one instant: ``grabbed[camera][kind]``, and ``grabbed.time_ns``.

        kinds: color, depth, instance, semantic, normal, flow, soiling (arrays, as in Camera.frame) and truth (as Camera.truth). While the world stands
        (lockstep, pause) it is the instant of the cameras' latest due frames; while it runs, the next at which all are due. CamrigError when
        there is none: the frames do not fall together, or each within ``timeout`` seconds was dropped for one of the cameras.
        """
        names = [camera if isinstance(camera, str) else camera.name for camera in cameras] or [camera.name for camera in self.cameras()]
        return grab(self, names, kinds, timeout)

    def visibility(self, cameras: Sequence[Camera | str] = (), classes: Sequence[str] = (), *, cell_m: float = 0.5, range_m: float = 30.0,
                   ground_z: float = 0.0) -> Network:
        """Who sees whom at this instant, how much and from which side, and what cameras share (docs/truth.md).

        cameras, classes: none is all. Shared ground is counted in squares of ``cell_m``, up to ``range_m`` from each camera. Over time,
        ``camrig.Handovers`` makes of it who enters and leaves which camera.
        """
        asked = {"cameras": [camera if isinstance(camera, str) else camera.name for camera in cameras], "classes": list(classes)}
        given = {key: names for key, names in asked.items() if names}
        reply = self.call("truth.network", **given, cell_m=cell_m, range_m=range_m, ground_z=ground_z)
        return Network(reply["time_ns"], reply["cameras"], reply["objects"], reply["overlaps"])

    # Photos

    def calibrate_plate(self, size: Sequence[int], **known: Any) -> dict[str, Any]:
        """From where a photo of this size was taken: camera, residuals and how sure it is (docs/backdrops.md).

        known: points, heights, lines, vfov_deg, click_px, ... as the file of ``camrig plate calibrate`` has them, and camera_files,
        what another program knows: {name of its file: its text} (fSpy, OpenCV, ROS; of COLMAP cameras.txt and images.txt).
        """
        return self.call("plate.calibrate", size=list(size), **known)

    def plate_light(self, **known: Any) -> dict[str, Any]:
        """Sun and sky of a photo, as ``lights`` and ``environment`` of a scene: sun=(azimuth, elevation), time= and place=, or shadow= and camera=."""
        return self.call("plate.light", **known)

    # World

    def step(self, *, seconds: float | None = None, nanoseconds: int | None = None, timeout: float = 120.0) -> dict[str, Any]:
        """Lockstep (or paused): moves the world on and returns when every due frame was sent to its readers."""
        return self.client.call("world.step", step_params(seconds, nanoseconds), timeout_s=timeout)

    def pause(self) -> dict[str, Any]:
        return self.call("world.pause")

    def resume(self) -> dict[str, Any]:
        return self.call("world.resume")

    def save(self, name: str) -> dict[str, Any]:
        """The world of a rig that was started with --log, in a file beside that; `serve --replay FILE` makes it again and compares."""
        return self.call("world.save", name=name)

    def status(self) -> dict[str, Any]:
        return self.call("world.status")

    def load(self, scene: str | os.PathLike[str], timeout: float = 120.0) -> dict[str, Any]:
        """Another world: a file, or the name of a shipped scene ("hall"). The path is the rig's, so that of a file here is made absolute."""
        found = os.path.abspath(scene) if os.path.isfile(scene) else os.fspath(scene)
        return self.client.call("world.load", {"scene": found}, timeout_s=timeout)

    # Actors and events

    def actors(self) -> list[dict[str, Any]]:
        """All actors, in the order they came: name, position, velocity, yaw_deg, behaviour, ..."""
        return self.call("actor.list")["actors"]

    def spawn_actor(self, name: str, model: str, **keys: Unpack[ActorOptions]) -> dict[str, Any]:
        """Puts an actor into the world; keys as in a scene file (``object_class`` for ``class``)."""
        return self.call("actor.spawn", name=name, model=model, **{"class" if key == "object_class" else key: value for key, value in keys.items()})

    def set_actor(self, name: str, **keys: Unpack[ActorChanges]) -> dict[str, Any]:
        """Changes an actor: behaviour, position, yaw_deg, play, attach, detach."""
        return self.call("actor.set", name=name, **keys)

    def steer(self, actors: Mapping[str, Steering]) -> dict[str, Any]:
        """Moves actors by your own program: {name: {"velocity": [x, y, z]} or {"position": ..., "seconds": ...}}."""
        return self.call("actor.steer", actors=[{"name": name, **how} for name, how in actors.items()])

    def remove_actor(self, name: str) -> dict[str, Any]:
        return self.call("actor.remove", name=name)

    def objects(self) -> list[dict[str, Any]]:
        """Everything that has an identity in pictures, actors too, by id: name, class, model, position, hidden, ..."""
        return self.call("object.list")["objects"]

    def object(self, name: str) -> dict[str, Any]:
        """One of them, with its box along the world's axes."""
        return self.call("object.get", name=name)

    def spawn_object(self, name: str, model: str, **keys: Any) -> dict[str, Any]:
        """Puts in what stands where it is; keys as in a scene file (``object_class`` for ``class``)."""
        return self.call("object.spawn", name=name, model=model, **{"class" if key == "object_class" else key: value for key, value in keys.items()})

    def set_object(self, name: str, **keys: Any) -> dict[str, Any]:
        """Changes an object or an actor: hidden, scale; of objects also position, yaw_deg or orientation."""
        return self.call("object.set", name=name, **keys)

    def remove_object(self, name: str) -> dict[str, Any]:
        return self.call("object.remove", name=name)

    def events(self) -> list[dict[str, Any]]:
        """The events that are there, and how often each has fired."""
        return self.call("event.list")["events"]

    def add_event(self, name: str, when: Trigger, do: Sequence[Action] = (), limit: int = 0) -> dict[str, Any]:
        """Adds an event; `when` and `do` as in a scene file."""
        return self.call("event.add", name=name, when=dict(when), do=[dict(action) for action in do], limit=limit)

    def act(self, *do: Action) -> dict[str, Any]:
        """Does at once what an event's actions do: ``rig.act({"action": "light", "light": "lamp", "intensity": 0})``."""
        return self.call("event.act", do=[dict(action) for action in do])

    def remove_event(self, name: str) -> dict[str, Any]:
        return self.call("event.remove", name=name)

    def wait_events(self, since: int = 0, timeout: float = 10.0) -> dict[str, Any]:
        """The events that have fired after number `since`; waits up to `timeout` seconds for one. Go on with ["last"]."""
        return self.client.call("event.wait", {"since": since, "timeout_s": timeout}, timeout_s=timeout + 20.0)

    # The rig

    def record(self, folder: str | os.PathLike[str], cameras: Sequence[Camera | str] = (), *, seconds: float | None = None,
               frames: int | None = None, format: str = "png", depth: str | None = None, flow: bool = False, masks: bool = False,
               soiling: bool = False, yolo: bool = False, timeout: float | None = None) -> dict[str, Any]:
        """Writes a data set on this machine with `camrig record` (docs/truth.md): every due frame of these cameras, or of all, with labels.

        seconds of world time, or instants; a running world stands meanwhile. format: png or jpeg, of the pictures; depth: npy or png; flow: optical flow;
        masks: instance pictures and COCO masks; soiling: what hides the scene; yolo: YOLO labels. The rig may be another machine's (connect with ``port``).
        """
        if self._control is None:
            raise CamrigError("unsupported", "record: goes over the Unix socket or TCP (serve --tcp, connect(host=, port=)), not over HTTP")
        names = [camera if isinstance(camera, str) else camera.name for camera in cameras]
        options = record_options(folder, names, seconds=seconds, frames=frames, format=format, depth=depth, flow=flow, masks=masks, soiling=soiling, yolo=yolo)
        return record(self.program, self._control, self.token, options, timeout)

    def randomize(self, seed: int, kinds: Sequence[str] = ("light", "clothes")) -> dict[str, Any]:
        """Light and people's clothes by chance, from now on: equal seeds make equal changes. Gives places in the scene file and their values, as a plan
        of `camrig farm record` takes them."""
        from .randomize import randomize

        return randomize(self, seed, kinds)

    def stats(self) -> dict[str, Any]:
        return self.call("stats.get")

    def info(self) -> dict[str, Any]:
        return self.call("server.info")

    def call(self, method: str, **params: Any) -> Any:
        """Any method of the control protocol, by its name."""
        return self.client.call(method, params)

    def device(self, camera: Camera | str) -> str:
        """A path or URL that an unmodified program opens to see this camera (for now: its MJPEG stream)."""
        return (camera if isinstance(camera, Camera) else Camera(self, camera)).url("mjpeg")

    @property
    def control(self) -> str | None:
        """Where the command line finds this rig (``--control``); None when it cannot."""
        return self._control

    @property
    def program(self) -> str:
        """The camrig program for this rig's command line: the one that start() ran, else what find_binary() finds."""
        return self._program or find_binary()

    @property
    def fault(self) -> Faults:
        """Lets cameras fail."""
        return Faults(self)

    @property
    def http_url(self) -> str:
        """``http://host:port``, without a slash at the end."""
        return self._url("http")

    @property
    def page_url(self) -> str:
        """The web page, with the key that it needs to command (docs/web-page.md): for a browser, and for nobody else to see."""
        path = self.info().get("key_file")
        try:
            key = Path(path).read_text().strip() if path else None
        except OSError as problem:
            raise CamrigError("unauthorized", f"{path}: {problem.strerror}; only the user whose rig it is reads its key") from problem
        return f"{self.http_url}/" + (f"#key={key}" if key else "")

    @property
    def rtsp_url(self) -> str:
        """``rtsp://host:port``, without a slash at the end; ``rtsps`` of a rig with a certificate."""
        return self._url("rtsp")

    @property
    def log(self) -> str:
        """What a rig started here has printed so far (its end); empty for one that was there before."""
        return self._owner.log if self._owner else ""

    def close(self) -> None:
        """Closes the connection; stops the rig if start() made it, and raises CamrigError if that did not end as it should (see
        start()). May be called twice."""
        self.client.close()
        if self._owner:
            self._owner.stop()

    def __enter__(self) -> Rig:
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        try:
            self.close()
        except CamrigError as problem:
            if value is None:
                raise
            # What went wrong in the block says more; from Python 3.11 on it says this too.
            if hasattr(value, "add_note"):
                value.add_note(str(problem))

    def _url(self, service: str) -> str:
        port = self._port(service)
        host = self._host or "127.0.0.1"
        scheme = self.info().get("rtsp_scheme", service) if service == "rtsp" else service
        return f"{scheme}://[{host}]:{port}" if ":" in host else f"{scheme}://{host}:{port}"

    def _port(self, service: str) -> int:
        if self._ports is None:
            info = self.info()
            self._ports = {key: info[key] for key in ("http", "rtsp") if isinstance(info.get(key), int)}
            # Reached by its Unix socket, the rig is on this machine, but maybe not on the loopback address.
            host = info.get("host")
            if self._host is None and isinstance(host, str) and host not in ("", "0.0.0.0", "::"):
                self._host = host
        port = self._ports.get(service)
        if not port:
            raise CamrigError("unsupported", f"this rig serves no {service.upper()}")
        return port


def default_control_path() -> str:
    """Where `camrig serve` puts its socket: $CAMRIG_CONTROL, else in $XDG_RUNTIME_DIR, else in /tmp. $CAMRIG_CONTROL may be an address."""
    if path := os.environ.get("CAMRIG_CONTROL"):
        return path
    if directory := os.environ.get("XDG_RUNTIME_DIR"):
        return os.path.join(directory, "camrig.sock")
    return f"/tmp/camrig-{os.getuid()}.sock"


def _is_address(control: str) -> bool:
    """Else it is a path; one with a colon has a slash too."""
    return control.startswith("http://") or (":" in control and "/" not in control)


def _host_and_port(address: str) -> tuple[str, int]:
    parts = re.fullmatch(r"(?:\[(.+)\]|(.+)):([0-9]{1,5})", address)
    if not parts or not 0 < int(parts[3]) < 65536:
        raise CamrigError("invalid_argument", f"connect: '{address}' is neither HOST:PORT nor the path of a socket (with a /)")
    return parts[1] or parts[2], int(parts[3])


def _parts_of(url: str) -> tuple[str, int, str | None]:
    """Host, port and, if it is there, the key of an address as `camrig serve` prints it."""
    try:
        parts = urllib.parse.urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError as problem:
        raise CamrigError("invalid_argument", f"connect: '{url}': {problem}") from None
    if not host or parts.path not in ("", "/") or parts.query:
        raise CamrigError("invalid_argument", f"connect: '{url}' is not http://HOST:PORT")
    return host, port or 80, urllib.parse.parse_qs(parts.fragment).get("key", [None])[0]


def connect(
    control: str | os.PathLike[str] | None = None,
    *,
    host: str | None = None,
    port: int | None = None,
    http_port: int | None = None,
    token: str | None = None,
    timeout: float = DEFAULT_TIMEOUT_S,
) -> Rig:
    """Connects to a running rig and checks that it answers.

    control: its Unix socket, or "HOST:PORT": control over TCP (`serve --tcp`), or "http://HOST:PORT": control over HTTP (`POST /rpc`),
    which every rig has; the link that `camrig serve` prints will do. Default: as for the command line, $CAMRIG_CONTROL first. host with
    port or http_port is the same.
    token: where the rig asks for one; the key of a rig of this user on this machine is found. timeout: seconds for each call that names
    none itself.
    """
    has_parts = host is not None or port is not None or http_port is not None
    if has_parts and (control or (port is None) == (http_port is None)):
        raise CamrigError("invalid_argument", "connect: give control, or host with either port (TCP) or http_port")
    if has_parts:
        host = host or "127.0.0.1"
    else:
        control = control or default_control_path()
    if isinstance(control, str) and _is_address(control):
        if control.startswith("http://"):
            host, http_port, key = _parts_of(control)
            return connect(host=host, http_port=http_port, token=token or key, timeout=timeout)
        host, port = _host_and_port(control)
        return connect(host=host, port=port, token=token, timeout=timeout)
    if host is None:
        assert control is not None
        path = os.fspath(control)
        rig = Rig(Client(unix_connector(path), timeout_s=timeout), control=path, token=token)
    elif port is not None:
        address = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
        rig = Rig(Client(tcp_connector(host, port), token, timeout), control=address, host=host, token=token)
    else:
        assert http_port is not None
        rig = Rig(Client(http_connector(host, http_port, token), timeout_s=timeout), host=host, token=token)
    try:
        rig.info()
    except BaseException:
        rig.close()
        raise
    return rig
