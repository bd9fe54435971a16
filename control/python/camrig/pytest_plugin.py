"""The fixture `rig`: a rig for each test that asks for one.

    @pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep", device="cpu", args=["--quality", "fast"])
    def test_something(rig): ...
"""

from __future__ import annotations

from typing import Any, Iterator

import pytest

from . import launch
from .rig import Rig

_DEFAULTS: dict[str, Any] = {"scene": "scenes/minimal.json", "mode": "lockstep"}
_RIG = pytest.StashKey[Rig]()


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line(
        "markers",
        "camrig(scene, mode, device, seed, quality, args, ...): options of camrig.start for the fixture `rig`; "
        "default: scenes/minimal.json in lockstep",
    )


@pytest.fixture
def rig(request: pytest.FixtureRequest) -> Iterator[Rig]:
    """A running rig of this test's own, stopped after it; its log is shown when the test fails. A rig that then does not end with
    exit code 0 and in time fails the test."""
    options = dict(_DEFAULTS)
    for marker in reversed(list(request.node.iter_markers("camrig"))):
        if marker.args:
            raise pytest.UsageError("marker camrig: give its options by name, as in camrig(scene='scenes/hall.json')")
        options.update(marker.kwargs)
    scene = options.pop("scene")
    below_root = request.config.rootpath / scene
    with launch.start(below_root if below_root.is_file() else scene, **options) as running:
        request.node.stash[_RIG] = running
        yield running


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Iterator[None]:
    outcome: Any = yield
    report = outcome.get_result()
    running = item.stash.get(_RIG, None)
    if report.failed and running is not None and running.log:
        report.sections.append(("camrig log", running.log))
