"""Users of ONVIF devices: what each role may, by an unmodified client and by hand."""

import asyncio
import os
import urllib.error
import urllib.request

import httpx
import onvif
import pytest
import requests
import requests.auth
import zeep.exceptions

import camrig
from conftest import wait_until
from onvif_messages import TOKEN, listens, post, security
from ports import free_port

HEAD = {"preset": "ideal", "latency_s": 0.2, "speed_deg_s": 100, "acceleration_deg_s2": 400, "pan_limits_deg": [-90, 90], "tilt_limits_deg": [-60, 30]}
STOP = "<tptz:Stop><tptz:ProfileToken>dome</tptz:ProfileToken></tptz:Stop>"
STATUS = "<tptz:GetStatus><tptz:ProfileToken>dome</tptz:ProfileToken></tptz:GetStatus>"


@pytest.fixture
def users_file(tmp_path):
    file = tmp_path / "users"
    file.write_text("# who may\nann administrator password of ann\notto operator password-of-otto\nute user password-of-ute\n")
    file.chmod(0o600)
    return file


@pytest.fixture
def guarded(users_file):
    with camrig.start("minimal", mode="lockstep", args=["--onvif", "0", "--onvif-users", str(users_file)]) as rig:
        yield rig


def test_an_unmodified_client_may_what_its_role_may(guarded):
    rig, port = guarded, free_port()
    cam = rig.create_camera("dome", size=(320, 240), ptz=HEAD, outputs=[{"kind": "onvif", "port": port}])
    wait_until(lambda: listens(port), what="the camera's port")
    move = {"ProfileToken": "dome", "Position": {"PanTilt": {"x": 0.5, "y": 0}}}

    async def session(user, password, use):
        device = onvif.ONVIFCamera("127.0.0.1", port, user, password)
        try:
            await device.update_xaddrs()
            await use(device)
        finally:
            await device.close()

    async def look(device):
        assert [one.token for one in await (await device.create_media_service()).GetProfiles()][0] == "dome"
        assert (await device.get_snapshot("dome", basic_auth=False))[:2] == b"\xff\xd8"

    async def turns(device):
        await look(device)
        await (await device.create_ptz_service()).AbsoluteMove(move)

    async def only_looks(device):
        await look(device)
        ptz = await device.create_ptz_service()
        before = (await ptz.GetStatus({"ProfileToken": "dome"})).Position.PanTilt.x
        with pytest.raises(zeep.exceptions.Fault, match="not Authorized"):
            await ptz.AbsoluteMove(move)
        with pytest.raises(zeep.exceptions.Fault, match="not Authorized"):
            await (await device.create_devicemgmt_service()).GetUsers()
        rig.step(seconds=3)
        assert (await ptz.GetStatus({"ProfileToken": "dome"})).Position.PanTilt.x == before

    async def reads_users(device):
        users = await (await device.create_devicemgmt_service()).GetUsers()
        assert [(one.Username, one.UserLevel) for one in users] == [("ann", "Administrator"), ("otto", "Operator"), ("ute", "User")]
        assert all(not one.Password for one in users)

    async def may_nothing(device):
        with pytest.raises(zeep.exceptions.Fault, match="not Authorized"):
            await (await device.create_media_service()).GetProfiles()

    asyncio.run(session("ute", "password-of-ute", only_looks))
    assert cam.ptz.status()["pan_deg"] == 0
    asyncio.run(session("otto", "password-of-otto", turns))
    rig.step(seconds=3)
    assert cam.ptz.status()["pan_deg"] == -45
    asyncio.run(session("ann", "password of ann", reads_users))
    asyncio.run(session("ute", "password-of-otto", may_nothing))


def test_nobody_is_anonymous_on_loopback_and_an_answer_to_digest_is_good_once(guarded):
    guarded.create_camera("dome", size=(320, 240), ptz=HEAD)
    port = guarded.call("server.info")["onvif"]
    for operation, status in (("<tds:GetSystemDateAndTime/>", 200), ("<tds:GetCapabilities/>", 200), (STATUS, 401), (STOP, 401), ("<tds:GetUsers/>", 401)):
        assert post(port, operation)[0] == status, operation
    url = f"http://127.0.0.1:{port}/cameras/dome/snapshot.jpg"
    with pytest.raises(urllib.error.HTTPError, match="401") as refused:
        urllib.request.urlopen(url)
    challenge = refused.value.headers["WWW-Authenticate"]
    assert challenge.startswith("Digest ") and "stale" not in challenge

    with requests.Session() as session:
        session.auth = requests.auth.HTTPDigestAuth("ute", "password-of-ute")
        answers = [session.get(url) for _ in range(3)]
        assert [one.status_code for one in answers] == [200] * 3
        assert [len(one.history) for one in answers] == [1, 0, 0], "the next message counts on with the same nonce"
        shown = answers[-1].request.headers["Authorization"]
    again = requests.get(url, headers={"Authorization": shown})
    assert again.status_code == 401 and "stale=true" in again.headers["WWW-Authenticate"]
    with httpx.Client(auth=httpx.DigestAuth("ute", "password-of-ute")) as client:
        assert [client.get(url).status_code for _ in range(3)] == [200] * 3
    for user, password in (("ute", "password-of-otto"), ("nobody", "password-of-ute")):
        wrong = requests.get(url, auth=requests.auth.HTTPDigestAuth(user, password))
        assert wrong.status_code == 401 and "stale" not in wrong.headers["WWW-Authenticate"]
    # By digest in the place of WS-UsernameToken, roles hold as well.
    text = requests.post(f"http://127.0.0.1:{port}/onvif/device_service", auth=requests.auth.HTTPDigestAuth("ute", "password-of-ute"),
                         data=f'<e:Envelope xmlns:e="http://www.w3.org/2003/05/soap-envelope" xmlns:tptz="http://www.onvif.org/ver20/ptz/wsdl"><e:Body>{STOP}</e:Body></e:Envelope>').text
    assert "role does not allow" in text


def test_the_token_is_an_administrators_and_read_only_holds_for_all(users_file, tmp_path):
    token_file = tmp_path / "token"
    token_file.write_text(TOKEN + "\n")
    args = ["--onvif", "0", "--onvif-users", str(users_file), "--token-file", str(token_file), "--read-only"]
    with camrig.start("minimal", mode="lockstep", args=args) as rig:
        rig.create_camera("dome", size=(320, 240), ptz=HEAD)
        port = rig.call("server.info")["onvif"]
        assert post(port, "<tds:GetUsers/>", security(TOKEN, user="ute"))[1].count("<tt:Username>") == 3
        status, text, _ = post(port, STOP, security("password of ann", nonce=b"another", user="ann"))
        assert status == 400 and "--read-only" in text
        assert "ter:NotAuthorized" in post(port, "<tds:CreateUsers/>", security("password-of-otto", nonce=b"third", user="otto"))[1]


@pytest.mark.parametrize(
    "text, mode, why",
    [
        ("ute user password\n", 0o640, "chmod 600"),
        ("ute user password\nann admin password\n", 0o600, "users:2: after the name comes a role: administrator, operator or user"),
        (None, 0, "cannot be read"),
    ],
)
def test_a_wrong_file_of_users_ends_the_start_with_the_reason(tmp_path, text, mode, why):
    file = tmp_path / "users"
    if text is not None:
        file.write_text(text)
        os.chmod(file, mode)
    with pytest.raises(camrig.CamrigError, match=f"(?s)--onvif-users.*{why}"):
        camrig.start("minimal", mode="lockstep", args=["--onvif", "0", "--onvif-users", str(file)])
