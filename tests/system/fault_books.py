"""The books of cameras that fail: nothing is due that was neither delivered, nor dropped by a fault, nor by an overloaded rig."""

import time

import pytest


def unbalanced(rig, on_way=2):
    """What does not add up, of every camera, output and reader; `on_way`: frames that a reader may be waiting for."""
    found = []

    def check(what, holds):
        if not holds:
            found.append(what)

    for camera in rig.stats()["cameras"]:
        name = camera["name"]
        check(f"{name}: due {camera['due']}, rendered {camera['rendered']}, dropped {camera['dropped']}", camera["due"] == camera["rendered"] + camera["dropped"])
        check(f"{name}: dropped {camera['dropped']}, for {camera['dropped_for']}", camera["dropped"] == sum(camera["dropped_for"].values()))
        for output in camera["outputs"]:
            said = f"{name}, {output['format']}: { {key: value for key, value in output.items() if isinstance(value, int)} }"
            check(said, output["due"] == output["received"] + output["fault"] + output["not_drawn"])
            check(said, 0 <= output["received"] - output["encoded"] - output["dropped"] - output["failed"] - output["kept_back"] <= 2)
            for reader in output["readers"]:
                check(f"{name}: {reader}", 0 <= reader["offered"] - reader["delivered"] - reader["dropped"] <= on_way)
                check(f"{name}: {reader}", reader["fault"] <= reader["dropped"])
    return found


def check_books(rig, on_way=2):
    """Fails when they do not balance; frames that are on their way get time to arrive."""
    deadline = time.monotonic() + 10
    while (found := unbalanced(rig, on_way)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not found


@pytest.fixture(autouse=True)
def books_balance(request):
    """After each test with a rig, in every module that imports it."""
    if "rig" not in request.fixturenames:
        yield
        return
    rig = request.getfixturevalue("rig")
    yield
    check_books(rig, on_way=2 + 30 * any(one["kind"] == "late" for one in rig.fault.list()))
