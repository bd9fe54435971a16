"""WS-Discovery by an unmodified client, in a network of its own: two interfaces and nobody else."""

import os
import pathlib
import subprocess
import sys
import textwrap

import camrig

# What is sent to a group goes to those who listen on the same interface of this machine too, so that rig and clients are both on `near`, which has
# addresses of two networks.
SETUP = """
set -e
ip link set lo up
ip link add near type veth peer name far
ip addr add 10.99.0.1/24 dev near && ip addr add 10.98.0.1/24 dev near && ip addr add 10.97.0.1/24 dev far
ip link set near up && ip link set far up
ip route add 224.0.0.0/4 dev near
exec "$@"
"""

CLIENT = """
import socket, struct, sys, time
import camrig
from wsdiscovery import QName, Scope
from wsdiscovery.discovery import ThreadedWSDiscovery

ONVIF = "onvif://www.onvif.org/"
NETWORK = "http://www.onvif.org/ver10/network/wsdl"
with camrig.start("minimal", mode="lockstep", args=["--host", "10.99.0.1", "--token-file", sys.argv[1], "--onvif", "0", "--onvif-discovery", "near"]) as rig:
    rig.create_camera("dome", size=(320, 240), ptz={"preset": "dome"}, outputs=[{"kind": "onvif", "port": 18081}])
    rig.create_camera("plain", size=(320, 240))
    client = ThreadedWSDiscovery()
    client.start()

    def found(by=client, until=(), **how):
        # More searches while some of `until` have not answered: on a busy machine that may take longer than a search.
        known = {}
        for _ in range(5):
            known |= {one.getXAddrs()[0]: [scope.getValue() for scope in one.getScopes()] for one in by.searchServices(timeout=1, **how)}
            if known.keys() >= set(until):
                break
        return known

    try:
        hub = f"http://10.99.0.1:{rig.call('server.info')['onvif']}/onvif/device_service"
        dome = "http://10.99.0.1:18081/onvif/device_service"
        all_of_them = found(until=[hub, dome], types=[QName(NETWORK, "NetworkVideoTransmitter")])
        assert set(all_of_them) == {hub, dome}, all_of_them
        assert ONVIF + "name/dome" in all_of_them[dome] and ONVIF + "type/ptz" in all_of_them[dome]
        # What Home Assistant asks for, until and from 2026; then answers must name the question.
        assert set(found(until=[hub, dome], scopes=[Scope(ONVIF + "Profile/Streaming")])) == {hub, dome}
        strict = ThreadedWSDiscovery(ttl=4, relates_to=True)
        strict.start()
        assert set(found(strict, [hub, dome], types=[QName(NETWORK, "NetworkVideoTransmitter", "dp0")], scopes=[Scope(ONVIF + "Profile/Streaming")])) == {hub, dome}
        strict.stop()
        assert set(found(until=[dome], scopes=[Scope(ONVIF + "name/dome")])) == {dome}
        assert not found(types=[QName(NETWORK, "Printer")])
        heard = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        heard.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        heard.bind(("239.255.255.250", 3702))
        heard.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton("239.255.255.250") + socket.inet_aton("10.99.0.1"))
        heard.settimeout(20)

        def hears(*words):
            while True:
                text = heard.recv(65536).decode()
                if all(word in text for word in words):
                    return text

        rig.camera("plain").set(outputs=[{"kind": "onvif", "port": 18082}])
        assert "http://10.99.0.1:18082/onvif/device_service" in hears("discovery/Hello", "name/plain")
        rig.camera("plain").set(outputs=[])
        hears("discovery/Bye")
        assert set(found(until=[hub, dome])) == {hub, dome}

        # A question to the rig's own address, on another interface, or with the address of another network as its sender, has no answer.
        probe = ('<e:Envelope xmlns:e="http://www.w3.org/2003/05/soap-envelope" xmlns:a="http://schemas.xmlsoap.org/ws/2004/08/addressing" '
                 'xmlns:d="http://schemas.xmlsoap.org/ws/2005/04/discovery"><e:Header><a:Action>http://schemas.xmlsoap.org/ws/2005/04/discovery/Probe</a:Action>'
                 '<a:To>urn:schemas-xmlsoap-org:ws:2005:04:discovery</a:To><a:MessageID>urn:uuid:7</a:MessageID></e:Header>'
                 '<e:Body><d:Probe/></e:Body></e:Envelope>').encode()

        def answers(to, sender, interface="10.99.0.1", count=1):
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
                asking.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 8 << 20)
                asking.bind((sender, 0))
                asking.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(interface))
                for _ in range(count):
                    asking.sendto(probe, (to, 3702))
                asking.settimeout(1)
                got = 0
                try:
                    while asking.recv(65536):
                        got += 1
                except (TimeoutError, ConnectionRefusedError):
                    return got

        group = "239.255.255.250"
        assert any(answers(group, "10.99.0.1") == 2 for _ in range(5))
        assert answers("10.99.0.1", "10.99.0.1") == 0
        assert answers(group, "10.98.0.1") == 0
        # Somebody listens there, so that the question comes to this machine's programs.
        heard.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(group) + socket.inet_aton("10.97.0.1"))
        assert answers(group, "10.99.0.1", interface="10.97.0.1") == 0
        for _ in range(5):  # answers() waits a second for one, which a busy machine may need alone
            begin = time.monotonic()
            flood = answers(group, "10.99.0.1", count=3000)
            assert flood <= 256 + 64 * (time.monotonic() - begin + 1), flood
            if flood:
                break
        assert flood > 0
        rig.call("server.shutdown")
        hears("discovery/Bye")
    finally:
        client.stop()
print("all found")
"""


def test_an_unmodified_client_finds_devices_on_the_named_interface_only(tmp_path):
    token, script = tmp_path / "token", tmp_path / "client.py"
    token.write_text("discovery-test-token\n")
    script.write_text(textwrap.dedent(CLIENT))
    path = os.pathsep.join([str(pathlib.Path(camrig.__file__).parent.parent), os.environ.get("PYTHONPATH", "")])
    command = ["unshare", "-rn", "sh", "-c", SETUP, "sh", sys.executable, str(script), str(token)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, env={**os.environ, "PYTHONPATH": path}, check=False)
    assert done.returncode == 0 and "all found" in done.stdout, done.stdout + done.stderr
