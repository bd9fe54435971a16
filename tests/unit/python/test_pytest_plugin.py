"""The fixture `rig`, in a pytest run of its own."""

import os
from pathlib import Path

import camrig


def run(pytester, monkeypatch, fake_binary, source):
    monkeypatch.setenv("CAMRIG_BIN", str(fake_binary))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(Path(camrig.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]))
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # installed or not: load it once, by name
    pytester.makepyfile(source)
    return pytester.runpytest_subprocess("-p", "camrig.pytest_plugin", "--strict-markers")


def test_each_test_has_a_rig_of_its_own_as_its_marker_says(pytester, monkeypatch, fake_binary):
    result = run(
        pytester,
        monkeypatch,
        fake_binary,
        """
        import pytest

        def option(rig, name):
            arguments = rig.info()["arguments"]
            return arguments[arguments.index(name) + 1]

        def test_defaults(rig):
            rig.create_camera("lobby")
            assert rig.info()["arguments"][1].endswith("scenes/minimal.json")
            assert option(rig, "--mode") == "lockstep"

        @pytest.mark.camrig(scene="my.json", device="cpu", seed=3)
        class TestMarked:
            @pytest.mark.camrig(mode="realtime")
            def test_nearest_marker_wins(self, rig):
                assert rig.cameras() == []
                assert rig.info()["arguments"][1] == "my.json"
                assert (option(rig, "--mode"), option(rig, "--device"), option(rig, "--seed")) == ("realtime", "cpu", "3")
        """,
    )
    result.assert_outcomes(passed=2)


def test_a_failure_shows_the_log_of_the_rig(pytester, monkeypatch, fake_binary):
    result = run(pytester, monkeypatch, fake_binary, "def test_fails(rig): assert False")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*camrig log*", "fake rig: serve *"])


def test_a_rig_that_ends_badly_fails_its_test(pytester, monkeypatch, fake_binary):
    source = "import pytest\n@pytest.mark.camrig(scene='failing.json')\ndef test_x(rig): pass"
    result = run(pytester, monkeypatch, fake_binary, source)
    result.assert_outcomes(passed=1, errors=1)
    assert result.ret == 1
    result.stdout.fnmatch_lines(["*with exit code 3*"])


def test_a_rig_that_cannot_start_is_an_error_with_its_reason(pytester, monkeypatch, fake_binary):
    source = "import pytest\n@pytest.mark.camrig(scene='broken.json')\ndef test_x(rig): pass"
    result = run(pytester, monkeypatch, fake_binary, source)
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["*is too small*"])
