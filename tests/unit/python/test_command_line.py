"""How a command in Python finds its rig, and how it fails."""

import json
import sys

import pytest

import camrig
import fake_rig
from camrig.command_line import Parser, connect_as_told, rig_options, run


def parse(*arguments):
    parser = Parser(prog="camrig test", parents=[rig_options()])
    parser.add_subparsers(dest="what").add_parser("sub", parents=[rig_options()])
    return parser.parse_args(arguments)


@pytest.fixture(autouse=True)
def clean_environment(monkeypatch):
    for name in ("CAMRIG_CONTROL", "CAMRIG_TOKEN_FILE"):
        monkeypatch.delenv(name, raising=False)


def test_the_rig_is_that_of_the_environment_or_of_the_option_before_or_after_the_subcommand(fake, tmp_path, monkeypatch):
    path = str(tmp_path / "control.sock")
    for arguments in (["--control", path, "sub"], ["sub", "--control", path]):
        with connect_as_told(parse(*arguments)) as rig:
            assert rig.info()["http"] == 8123
    monkeypatch.setenv("CAMRIG_CONTROL", path)
    with connect_as_told(parse("sub")) as rig:
        assert rig.info()["http"] == 8123


def test_host_and_port_is_control_over_tcp(fake):
    server, port = fake_rig.serve_tcp(fake)
    with connect_as_told(parse("--control", f"127.0.0.1:{port}")) as rig:
        assert rig.info()["http"] == 8123
    server.shutdown()
    server.server_close()


def test_the_token_of_the_file_goes_into_urls(fake, tmp_path, monkeypatch):
    token_file = tmp_path / "token"
    token_file.write_text("secret-token\n")
    monkeypatch.setenv("CAMRIG_CONTROL", str(tmp_path / "control.sock"))
    monkeypatch.setenv("CAMRIG_TOKEN_FILE", str(token_file))
    with connect_as_told(parse()) as rig:
        assert camrig.Camera(rig, "a").url().endswith("?token=secret-token")


def test_failures_are_one_line_and_exit_code_1(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["x", "--control", str(tmp_path / "nobody.sock")])
    assert run(lambda arguments: connect_as_told(parse(*arguments)) and 0) == 1
    error = capsys.readouterr().err
    assert error.startswith("camrig: no rig at") and error.count("\n") == 1
    with pytest.raises(camrig.CamrigError) as caught:
        connect_as_told(parse("--control", "host:port"))
    assert caught.value.kind == "invalid_argument"
    with pytest.raises(camrig.CamrigError) as caught:
        connect_as_told(parse("--token-file", str(tmp_path / "none")))
    assert "none" in caught.value.message


def test_wrong_usage_is_one_line_and_exit_code_2(capsys):
    with pytest.raises(SystemExit) as caught:
        parse("--nonsense")
    assert caught.value.code == 2
    error = capsys.readouterr().err
    assert error.startswith("camrig: ") and "--nonsense" in error and error.count("\n") == 1


def test_with_json_failures_are_json(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["x", "--json", "--control", str(tmp_path / "nobody.sock")])
    assert run(lambda arguments: connect_as_told(parse(*arguments)) and 0) == 1
    error = json.loads(capsys.readouterr().err)["error"]
    assert error["kind"] == "unavailable" and error["message"].startswith("no rig at")
    with pytest.raises(SystemExit) as caught:
        parse("--nonsense")
    assert caught.value.code == 2
    error = json.loads(capsys.readouterr().err)["error"]
    assert error["kind"] == "invalid_argument" and "--nonsense" in error["message"]
