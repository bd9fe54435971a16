"""The fixtures `rig`, a rig for each test that asks for one, and `campaign`, which runs campaigns of faults on it.

    @pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep", device="cpu", args=["--quality", "fast"])
    def test_something(rig): ...

    @pytest.mark.camrig(scene="scenes/hall.json", mode="realtime")
    def test_my_program(campaign):
        assert campaign("network", program="my-program {rtsp}", check={"well": "frame", "every_s": 2}).is_good
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Callable, Iterator, Mapping

import pytest

from . import campaign as campaigns
from . import launch
from .campaign import Report
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


@pytest.fixture
def campaign(rig: Rig, tmp_path: Path, request: pytest.FixtureRequest) -> Callable[..., Report]:
    """``campaign(what, **changes)``: runs a campaign (a file, a shipped one's name, or a dict; `changes` replace its keys) on the fixture `rig`,
    which must be realtime, and writes its report into the test's tmp_path."""

    def run(what: str | os.PathLike[str] | Mapping[str, Any], **changes: Any) -> Report:
        if not isinstance(what, Mapping) and (below_root := request.config.rootpath / what).is_file():
            what = below_root
        loaded = campaigns.load(what, changes)
        report = campaigns.run(rig, loaded)
        campaigns.write(report, tmp_path / f"campaign-{loaded.name}")
        return report

    return run


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Iterator[None]:
    outcome: Any = yield
    report = outcome.get_result()
    running = item.stash.get(_RIG, None)
    if report.failed and running is not None and running.log:
        report.sections.append(("camrig log", running.log))
