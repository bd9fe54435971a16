"""Home Assistant's own ONVIF integration, unmodified, with a camera of camrig: see README.md."""

from __future__ import annotations

import argparse
import asyncio
import logging
import tempfile

from homeassistant import bootstrap, config, config_entries, core, loader
from homeassistant.components.camera import async_get_image, async_get_stream_source
from homeassistant.const import __version__
from homeassistant.helpers import entity_registry
from homeassistant.setup import async_setup_component

from client_bench import TOKEN, dome, end, free_port, verdict


async def until(condition, seconds=20.0):
    """True once condition() is; False where it is not within `seconds`."""
    loop = asyncio.get_running_loop()
    deadline = loop.time() + seconds
    while not condition():
        if loop.time() > deadline:
            return False
        await asyncio.sleep(0.02)
    return True


def stands(cam, **place):
    """Whether the head stands at this place, in degrees."""
    status = cam.ptz.status()
    return not status["turning"] and not status["zooming"] and all(abs(status[name] - value) < 0.1 for name, value in place.items())


async def drive(hass, rig, cam, port):
    # As a person adds it: "Configure manually", which runs GetNetworkInterfaces and GetProfiles; first with a wrong password.
    flow = hass.config_entries.flow
    step = await flow.async_init("onvif", context={"source": "user"})
    step = await flow.async_configure(step["flow_id"], {"auto": False})
    given = {"name": "dome", "host": "127.0.0.1", "port": port, "username": "camrig", "password": "wrong"}
    step = await flow.async_configure(step["flow_id"], given)
    verdict("a wrong password is told as one", step.get("errors") == {"password": "auth_failed"}, step.get("errors"))
    step = await flow.async_configure(step["flow_id"], given | {"password": TOKEN})
    await hass.async_block_till_done()
    verdict("the config flow makes an entry", step["type"] == "create_entry", step.get("title"))
    entry = step["result"]
    verdict("the entry is set up", entry.state.value == "loaded", entry.state.value)

    device = hass.data["onvif"][entry.unique_id]
    verdict("device information", (device.info.manufacturer, device.info.mac) == ("camrig", entry.unique_id), device.info)
    verdict("capabilities", all(vars(device.capabilities).values()), device.capabilities)
    verdict("profiles of H.264, with all moves", [profile.token for profile in device.profiles] == ["dome", "dome-sub"] and
            all(profile.ptz.continuous and profile.ptz.relative and profile.ptz.absolute for profile in device.profiles),
            [(profile.token, profile.video.resolution, profile.ptz.presets) for profile in device.profiles])
    entities = [one.entity_id for one in entity_registry.async_get(hass).entities.values() if one.config_entry_id == entry.entry_id]
    verdict("entities", any(one.startswith("camera.") for one in entities), len(entities))
    (camera,) = hass.states.async_entity_ids("camera")
    source = await async_get_stream_source(hass, camera)
    verdict("stream source", source == cam.url("rtsp").replace("//", f"//camrig:{TOKEN}@"), source)
    image = await async_get_image(hass, camera)
    login = entry.data.get("snapshot_auth")
    verdict("still picture by the snapshot", image.content[:2] == b"\xff\xd8" and login == "digest", f"{len(image.content)} bytes, {login}")

    async def ptz(**how):
        await hass.services.async_call("onvif", "ptz", {"entity_id": camera, **how}, blocking=True)

    await ptz(move_mode="AbsoluteMove", pan="RIGHT", tilt="UP", distance=0.5, speed=1)
    at = {"pan_deg": -45.0, "tilt_deg": 7.5}  # the head's limits are -90 to 90 and -60 to 30
    verdict("AbsoluteMove", await until(lambda: stands(cam, **at)), cam.ptz.status()["pan_deg"])
    await ptz(move_mode="RelativeMove", pan="LEFT", distance=0.25, speed=1)
    verdict("RelativeMove", await until(lambda: stands(cam, pan_deg=-22.5)), cam.ptz.status()["pan_deg"])
    await ptz(move_mode="ContinuousMove", pan="LEFT", distance=0.1, speed=1, continuous_duration=0.5)
    await until(lambda: stands(cam))
    pan = cam.ptz.status()["pan_deg"]
    verdict("ContinuousMove, ended by its Stop", -20 < pan < -12, pan)
    await ptz(move_mode="GotoPreset", preset="home")
    verdict("GotoPreset", await until(lambda: stands(cam, pan_deg=0, tilt_deg=0)), cam.ptz.status()["pan_deg"])

    # What moves has stood still for longer than the alarm lasts; then a box is set going, and the picture gets dark.
    def motion():
        return [state.state for state in hass.states.async_all("binary_sensor") if state.attributes.get("device_class") == "motion"]

    verdict("pull point, no webhook", (device.events.pullpoint_manager.state.name, device.events.webhook_manager.state.name == "STARTED") == ("STARTED", False),
            device.events.pullpoint_manager.state.name)
    verdict("motion sensors", await until(lambda: len(motion()) == 2), motion())
    rig.steer({"mover": {"velocity": [0, 0, 0]}})
    verdict("motion is over", await until(lambda: set(motion()) == {"off"}), motion())
    rig.steer({"mover": {"velocity": [0.5, 0, 0]}})
    verdict("motion is told", await until(lambda: set(motion()) == {"on"}), motion())
    sensors = {state.entity_id: state.state for state in hass.states.async_all("binary_sensor")}
    verdict("other sensors", len(sensors) > 2 and "unknown" not in sensors.values(), sensors)

    verdict("the entry is unloaded", await hass.config_entries.async_unload(entry.entry_id))
    verdict("and its pull point given back", await until(lambda: device.events.pullpoint_manager.state.name == "STOPPED"))


async def run(rig, cam, port, folder):
    # Its core and the components that the integration stands on, without recorder, front end and the like.
    hass = core.HomeAssistant(folder)
    hass.config.skip_pip = True  # README.md says what must be there
    loader.async_setup(hass)
    hass.config_entries = config_entries.ConfigEntries(hass, {})
    await bootstrap.async_load_base_functionality(hass)
    await config.async_process_ha_core_config(hass, {})
    started = [await async_setup_component(hass, name, {"http": {"server_host": "127.0.0.1", "server_port": free_port()}})
               for name in ("homeassistant", "persistent_notification", "http")]
    await hass.async_start()
    verdict("Home Assistant starts", all(started), __version__)
    try:
        await drive(hass, rig, cam, port)
    finally:
        await hass.async_stop(force=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--verbose", action="store_true", help="Home Assistant's own log")
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.DEBUG if arguments.verbose else logging.ERROR)
    with tempfile.TemporaryDirectory() as folder, dome((640, 480)) as (rig, cam, port):
        asyncio.run(run(rig, cam, port, folder))
    end()


if __name__ == "__main__":
    main()
