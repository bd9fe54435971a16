"""camrig: a rig of virtual cameras that programs take for real ones.

    with camrig.start("scenes/hall.json", mode="lockstep") as rig:
        cam = rig.create_camera("mine", size=(640, 480), fps=25, vfov_deg=60, position=(2, 3, 2.8), look_at=(12, 9, 1))
        rig.step(seconds=0.2)
        frame = cam.frame()
"""

from . import tone
from .camera import Camera
from .code_strip import Code, read_code
from .errors import CamrigError, CamrigTimeout
from .frame import Frame
from .grab import Instant
from .launch import start
from .network import Handover, Handovers, Network, Passage
from .places import find_binary
from .projection import Projection
from .rig import Rig, connect, default_control_path

__version__ = "0.1.0"

__all__ = [
    "Camera",
    "CamrigError",
    "CamrigTimeout",
    "Code",
    "Frame",
    "Handover",
    "Handovers",
    "Instant",
    "Network",
    "Passage",
    "Projection",
    "Rig",
    "connect",
    "default_control_path",
    "find_binary",
    "read_code",
    "start",
    "tone",
]
