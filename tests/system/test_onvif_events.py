"""What ONVIF devices tell of by themselves, as Home Assistant's own library and parsers have it."""

import asyncio
import datetime
import pathlib
import re
import select
import socket

import onvif
import onvif_parsers
import pytest
import zeep.exceptions
from lxml import etree

from conftest import wait_until
from onvif_messages import SOAP, WSDL, envelope, listens, post, schemas
from ports import free_port

WSNT = "http://docs.oasis-open.org/wsn/b-2"


def device_port(rig, **options):
    """A camera as a device of its own, which sees the whole scene."""
    port = free_port()
    camera = rig.create_camera("hall", place="main", size=(320, 240), fps=25, outputs=[{"kind": "onvif", "port": port}], **options)
    wait_until(lambda: listens(port), what="the camera's port")
    return camera, port


async def hear(service, left, wanted, meanwhile=lambda: None):
    """Pulls and parses until a sensor, by the end of its topic, says what is `wanted`; what all of them say by the end of that answer. What came after it stays in `left`."""
    said = {}
    for _ in range(60):
        if not left:
            left += (await service.PullMessages({"MessageLimit": 100, "Timeout": datetime.timedelta(seconds=2)})).NotificationMessage
        while left:
            message = left.pop(0)
            topic = message.Topic._value_1
            for event in await onvif_parsers.parse(topic, "uid", message):
                said[topic] = event.value
                if topic.endswith(wanted[0]) and event.value == wanted[1]:
                    return said | {later.Topic._value_1: one.value for later in left for one in await onvif_parsers.parse(later.Topic._value_1, "uid", later)}
        await asyncio.to_thread(meanwhile)
    raise AssertionError(f"{wanted} was never told; {said}")


@pytest.mark.camrig(scene="minimal", mode="lockstep")
def test_home_assistants_client_hears_of_motion_darkness_and_scene_events(rig):
    camera, port = device_port(rig)
    lost, left = [], []

    async def client():
        device = onvif.ONVIFCamera("127.0.0.1", port, "viewer", "nobody asks for it")
        try:
            await device.update_xaddrs()
            assert (await device.get_capabilities())["Events"]["WSPullPointSupport"]
            properties = await (await device.create_events_service()).GetEventProperties()
            assert properties.FixedTopicSet
            manager = await device.create_pullpoint_manager(datetime.timedelta(minutes=10), lambda: lost.append(True))
            service = manager.get_service()
            await manager.set_synchronization_point()
            # The world stands, and so does the box in it.
            await hear(service, left, ("VideoSource/MotionAlarm", False))
            await hear(service, left, ("CellMotionDetector/Motion", True), lambda: rig.step(seconds=0.5))
            await hear(service, left, ("VideoSource/MotionAlarm", False), lambda: rig.steer({"mover": {"velocity": [0, 0, 0]}}) and rig.step(seconds=1))
            camera.set(controls={"brightness": -1})
            said = await hear(service, left, ("ImageTooDark/ImagingService", True), lambda: rig.step(seconds=0.5))
            assert not any(value for topic, value in said.items() if topic.endswith("ImageTooBright/ImagingService"))
            rig.add_event("doorbell", {"at_s": rig.status()["world_ns"] / 1e9 + 0.5})
            await hear(service, left, ("Device/Trigger/DigitalInput", True), lambda: rig.step(seconds=1))
            await hear(service, left, ("Device/Trigger/DigitalInput", False))
            await manager.stop()
            with pytest.raises(zeep.exceptions.Fault, match="no such subscription"):
                await service.PullMessages({"MessageLimit": 1, "Timeout": datetime.timedelta(seconds=1)})
        finally:
            await device.close()

    asyncio.run(client())
    assert not lost


def is_read(port, peer):
    """Whether all that came to `port` from the port `peer` has been read."""
    for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]:
        local, remote, state, queues = (line.split()[n] for n in (1, 2, 3, 4))
        if local.endswith(f":{port:04X}") and remote.endswith(f":{peer:04X}") and state == "01" and queues.endswith(":00000000"):
            return True
    return False


@pytest.mark.camrig(scene="minimal", mode="lockstep", args=["--onvif", "0"])
def test_nobody_watches_a_camera_for_events_until_somebody_subscribes(rig):
    _, port = device_port(rig)

    def drawn():
        return {one["name"]: one["rendered"] for one in rig.stats()["cameras"]}["hall"]

    def subscribe(topic):
        header = f'<wsnt:TopicExpression xmlns:wsnt="{WSNT}">{topic}</wsnt:TopicExpression>'
        text = post(port, f"<tev:CreatePullPointSubscription><tev:Filter>{header}</tev:Filter></tev:CreatePullPointSubscription>")[1]
        return re.search("Address>http://127.0.0.1:[0-9]+([^<]+)", text)[1]

    def pull(path, timeout="PT20S", at=port):
        return post(at, f"<tev:PullMessages><tev:Timeout>{timeout}</tev:Timeout><tev:MessageLimit>9</tev:MessageLimit></tev:PullMessages>", path=path)

    rig.step(seconds=1)
    before = drawn()
    post(port, "<tev:GetEventProperties/>")
    assert drawn() == before
    path = subscribe("tns1:VideoSource/MotionAlarm")
    status, text, _ = pull(path)
    assert status == 200 and 'PropertyOperation="Initialized"' in text and text.count("NotificationMessage>") == 2
    # A device tells of its own camera, and another one's subscriptions are none of its own.
    assert 'Value="hall"' in text and "main" not in text
    assert pull("/onvif/sub/4711")[0] == 400
    other, hub = free_port(), rig.call("server.info")["onvif"]
    rig.create_camera("yard", place="main", outputs=[{"kind": "onvif", "port": other}])
    wait_until(lambda: listens(other), what="the other camera's port")
    for elsewhere in (other, hub):
        status, text, _ = pull(path, "PT0S", at=elsewhere)
        assert status == 400 and "ResourceUnknownFault" in text
    # One that waits holds up nobody else, and Unsubscribe ends it.
    text = envelope("<tev:PullMessages><tev:Timeout>PT20S</tev:Timeout><tev:MessageLimit>9</tev:MessageLimit></tev:PullMessages>").encode()
    waiting = socket.create_connection(("127.0.0.1", port), 20)
    waiting.sendall(f"POST {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\nContent-Length: {len(text)}\r\n\r\n".encode() + text)
    wait_until(lambda: is_read(port, waiting.getsockname()[1]), what="the one that waits")
    assert post(port, "<tds:GetSystemDateAndTime/>")[0] == 200
    assert post(port, f'<w:Renew xmlns:w="{WSNT}"><w:TerminationTime>PT1H</w:TerminationTime></w:Renew>', path=path)[0] == 200
    assert not select.select([waiting], [], [], 0)[0]
    assert post(port, f'<w:Unsubscribe xmlns:w="{WSNT}"/>', path=path)[0] == 200
    answer = b"".join(iter(lambda: waiting.recv(65536), b"")).decode()
    waiting.close()
    assert " 200 " in answer.splitlines()[0] and "PullMessagesResponse" in answer and "NotificationMessage" not in answer
    assert "ResourceUnknownFault" in pull(path)[1]


@pytest.mark.camrig(scene="minimal", mode="lockstep")
def test_answers_about_subscriptions_are_valid_by_the_schemas_of_onvif(rig):
    _, port = device_port(rig)
    of_service = schemas()
    base = etree.XMLSchema(etree.parse(str(WSDL / "b-2.xsd")))

    def valid(operation, schema, path="/onvif/device_service"):
        status, text, _ = post(port, operation, path=path)
        assert status == 200, text
        (answer,) = etree.fromstring(text.encode()).find(f"{{{SOAP}}}Body")
        schema.assertValid(etree.fromstring(etree.tostring(answer)))
        return text

    path = re.search("Address>http://127.0.0.1:[0-9]+([^<]+)", valid("<tev:CreatePullPointSubscription/>", of_service["tev"]))[1]
    pull = "<tev:PullMessages><tev:Timeout>PT5S</tev:Timeout><tev:MessageLimit>50</tev:MessageLimit></tev:PullMessages>"
    assert "NotificationMessage" in valid(pull, of_service["tev"], path)
    valid("<tev:SetSynchronizationPoint/>", of_service["tev"], path)
    assert "NotificationMessage" in valid(pull, of_service["tev"], path)
    valid(f'<w:Renew xmlns:w="{WSNT}"><w:TerminationTime>PT60S</w:TerminationTime></w:Renew>', base, path)
    valid(f'<w:Unsubscribe xmlns:w="{WSNT}"/>', base, path)
