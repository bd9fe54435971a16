"""Messages to ONVIF devices, put together by hand: with prefixes of our own, and with wrong signatures too."""

import base64
import datetime
import hashlib
import pathlib
import socket
import urllib.error
import urllib.request

import onvif
from lxml import etree

from conftest import REPOSITORY

TOKEN = "onvif-test-token"
WSDL = pathlib.Path(onvif.__file__).parent / "wsdl"
SERVICES = {
    "tds": ("http://www.onvif.org/ver10/device/wsdl", "devicemgmt.wsdl"),
    "trt": ("http://www.onvif.org/ver10/media/wsdl", "media.wsdl"),
    "tptz": ("http://www.onvif.org/ver20/ptz/wsdl", "ptz.wsdl"),
    "timg": ("http://www.onvif.org/ver20/imaging/wsdl", "imaging.wsdl"),
    "tev": ("http://www.onvif.org/ver10/events/wsdl", "events.wsdl"),
}
SOAP = "http://www.w3.org/2003/05/soap-envelope"
TT = "http://www.onvif.org/ver10/schema"


def beside(name):
    """Where tools/setup put package `name` of tools/requirements-beside.txt."""
    places = list((REPOSITORY / ".venv/beside" / name).glob("lib/python*/site-packages"))
    assert len(places) == 1, f"{name} is not there: run tools/setup"
    return places[0]


def listens(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def envelope(operation, header=""):
    """The message whose body is `operation`, with prefixes of our own."""
    spaces = "".join(f' xmlns:{prefix}="{space}"' for prefix, (space, _) in SERVICES.items())
    return f'<e:Envelope xmlns:e="{SOAP}" xmlns:tt="{TT}"{spaces}><e:Header>{header}</e:Header><e:Body>{operation}</e:Body></e:Envelope>'


def post(port, operation, header="", fields=(), path="/onvif/device_service"):
    """The status and the answer to a message whose body is `operation`, with prefixes of our own."""
    request = urllib.request.Request(f"http://127.0.0.1:{port}{path}", envelope(operation, header).encode(), dict(fields))
    try:
        with urllib.request.urlopen(request, timeout=20) as answer:
            return answer.status, answer.read().decode(), answer.headers
    except urllib.error.HTTPError as refused:
        return refused.code, refused.read().decode(), refused.headers


def security(password, nonce=b"0123456789abcdef", age_s=0, user="viewer"):
    created = (datetime.datetime.now(datetime.timezone.utc) - datetime.timedelta(seconds=age_s)).strftime("%Y-%m-%dT%H:%M:%S.000Z")
    digest = base64.b64encode(hashlib.sha1(nonce + created.encode() + password.encode()).digest()).decode()
    return (
        '<Security xmlns="http://docs.oasis-open.org/wss/2004/01/oasis-200401-wss-wssecurity-secext-1.0.xsd"><UsernameToken>'
        f'<Username>{user}</Username>'
        f'<Password Type="http://docs.oasis-open.org/wss/2004/01/oasis-200401-wss-username-token-profile-1.0#PasswordDigest">{digest}</Password>'
        f"<Nonce>{base64.b64encode(nonce).decode()}</Nonce><Created>{created}</Created></UsernameToken></Security>"
    )


def schemas():
    """The schema of each service's messages, by prefix."""
    made = {}
    for prefix, (_, name) in SERVICES.items():
        tree = etree.fromstring((WSDL / name).read_bytes(), base_url=str(WSDL / name))
        schema = next(tree.iterfind(".//{http://www.w3.org/2001/XMLSchema}schema"))
        # As a document of its own; what it imports lies beside it.
        made[prefix] = etree.XMLSchema(etree.fromstring(etree.tostring(schema), base_url=str(WSDL / name)))
    return made
