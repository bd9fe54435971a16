"""The manifests of examples/farm: right by Kubernetes' own schema, and of options that the commands have. Nothing of it is run."""

import shlex
from types import SimpleNamespace

import kubernetes_validate
import pytest
import yaml
from conftest import REPOSITORY

from camrig.farm.live import up
from camrig.farm.__main__ import COMMANDS

FOLDER = REPOSITORY / "examples" / "farm"
VERSIONS = ("1.28.0", "1.31.0", "1.34.0")


def documents(name):
    return [document for document in yaml.safe_load_all((FOLDER / name).read_text()) if document]


def pods_of(document):
    """The pod templates in it, wherever they are."""
    if isinstance(document, list):
        return [pod for each in document for pod in pods_of(each)]
    if not isinstance(document, dict):
        return []
    own = [document["template"]] if "containers" in document.get("template", {}).get("spec", {}) else []
    return own + [pod for value in document.values() for pod in pods_of(value)]


@pytest.mark.parametrize("version", VERSIONS)
def test_manifests_are_right_by_the_schema_of_kubernetes(version):
    for document in documents("kubernetes.yaml"):
        kubernetes_validate.validate(document, version, strict=True)
    pods = [pod for document in documents("ray-job.yaml") for pod in pods_of(document)]
    assert len(pods) == 2
    for pod in pods:
        kubernetes_validate.validate({"apiVersion": "v1", "kind": "Pod", "metadata": {"name": "a"}, "spec": pod["spec"]}, version, strict=True)


def test_the_schema_finds_what_is_wrong():
    document = next(one for one in documents("kubernetes.yaml") if one["metadata"]["name"] == "camrig-node")
    document["spec"]["template"]["spec"]["containers"][0]["volumeMount"] = []
    with pytest.raises(kubernetes_validate.ValidationError):
        kubernetes_validate.validate(document, VERSIONS[-1], strict=True)


def test_containers_give_options_that_the_commands_have(monkeypatch):
    """Each container of camrig's image, by the parser that will read its words."""
    monkeypatch.setattr(up, "_door", lambda options: options)
    monkeypatch.setattr(up, "run_node", lambda options: options)
    monkeypatch.setattr(up.asyncio, "new_event_loop", lambda: SimpleNamespace(run_until_complete=lambda taken: taken))
    monkeypatch.setattr(up.os, "_exit", lambda code: ended.append(code))
    taken, ended = {}, []
    for document in documents("kubernetes.yaml"):
        for pod in pods_of(document):
            for container in pod["spec"]["containers"]:
                if container["image"] == "camrig-farm":
                    command, *words = container["args"]
                    getattr(up, COMMANDS[command][0].partition(":")[2])(words)
                    taken[command] = ended.pop()
    assert taken["node"].replicas == 3 and taken["node"].http == 8080 and taken["node"].args == ("--device=cpu",) and taken["node"].nats == taken["door"].nats
    assert taken["door"].tcp == ("0.0.0.0", 8555)
    (job,) = documents("ray-job.yaml")
    assert shlex.split(job["spec"]["entrypoint"])[:3] == ["camrig", "farm", "record"]
