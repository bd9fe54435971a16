"""On a machine without a GPU pictures are drawn without Mesa: it is neither linked nor loaded."""

import pathlib
import re

import camrig
import pytest

LIBRARIES = re.compile(r"/(lib(?:EGL|GL|GLX|GLES|OpenGL|GLdispatch|glapi|gbm|drm|LLVM|gallium)[^/\n]*\.so[^/\n]*|[^/\n]*_dri\.so)")
LENSES = (None, ("plumb_bob", [-0.28, 0.08, 0, 0, 0]), ("rational_polynomial", [0.3, -0.1, 0, 0, 0.01, 0.6, -0.05, 0.02]), ("equidistant", [0, 0, 0, 0]))


def mapped(process):
    return sorted(set(LIBRARIES.findall(pathlib.Path(f"/proc/{process.pid}/maps").read_text())))


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep", device="cpu")
def test_every_quality_lens_and_kind_is_drawn_without_a_library_of_opengl(rig, process):
    intrinsics = {"fx": 60, "fy": 60, "cx": 79.5, "cy": 59.5}
    number = 0
    for lens in LENSES:
        for quality, antialias in (("fast", "none"), ("fast", "coverage"), ("simple", "none"), ("simple", "coverage"), ("beautiful", "none"), ("beautiful", "auto")):
            options = {} if lens is None else {"lens": lens, "intrinsics": intrinsics}
            cam = rig.create_camera(f"eye{number}", place="lobby", size=(160, 120), fps=10, quality=quality, antialias=antialias, **options)
            number += 1
            rig.step(seconds=0.1)
            assert cam.frame().image.std() > 5
        assert cam.depth().shape == (120, 160)
        assert cam.instances().any()
        assert cam.frame(kind="normal").image.any()
        assert cam.truth()["objects"]
    assert mapped(process) == []
    # What is looked for is there once it is needed, or else this would find nothing ever.
    cam = rig.create_camera("sampled", place="lobby", size=(160, 120), fps=10, antialias="msaa4")
    try:
        cam.frame()
    except camrig.CamrigError as error:
        assert "libgl1-mesa-dri" in str(error)
    else:
        assert any(name.startswith("libEGL") for name in mapped(process))
