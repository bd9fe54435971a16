#include "control/rpc/method_shapes.h"

#include <algorithm>

#include "core/world/camera_fields.h"

namespace camrig::control {
namespace {

/// An object of a camera: words of its own, and the parts that the table has.
SharedObject object_of(const char* name, const char* summary) {
    const auto found =
        std::ranges::find(world::camera_fields(), name, [](const auto& entry) { return entry.field.name; });
    CHECK(found != world::camera_fields().end());
    return {name, summary, found->field.parts};
}

}  // namespace

std::vector<SharedObject> shared_objects() {
    return {
        object_of("pose",
                  "Where a camera is and how it is turned, in the world (right-handed, z up). Give at most one of "
                  "look_at, the angles and orientation; with none of them the camera looks along +x."),
        object_of("mount",
                  "Fixes a camera to an actor: a vehicle, a drone, a person. `pose` is then in the frame of the mount, "
                  "x ahead, y left, z up, and so is what look_at names; it moves with every picture. When the actor is "
                  "removed the camera stays where it was, and follows again when an actor of this name comes."),
        object_of(
            "ptz",
            "A pan/tilt/zoom head under the camera. `pose` is where it looks with the head at pan and tilt 0, and "
            "zoom multiplies the camera's focal length; world_pose is where it looks now. The methods ptz.* move "
            "it; a change of these figures puts it back to its begin."),
        object_of("clock",
                  "A clock of the camera's own, which is wrong. What it says (state to step_at_ns) is in stamp_ns and "
                  "steady_ns and in what outputs stamp pictures with; when the camera exposes (phase_ns to "
                  "trigger_jitter_ns) is in time_ns. docs/clocks.md says what each output shows."),
        object_of("sensor",
                  "A sensor behind the lens: it counts electrons, with noise, saturation and a converter of some bits, "
                  "and the picture is made of its numbers. A preset sets all figures, what is given beside it counts. "
                  "frame.get gives the numbers (kind sensor), frame.get and truth.get how the picture was taken. "
                  "docs/sensor.md has the model and the presets."),
        object_of("backdrop",
                  "A picture of a real place, which the camera took or might have: people and vehicles are drawn into "
                  "it through the camera's lens, hidden by proxies, the shapes of what it shows. Given as a whole. "
                  "Pixels are those of the picture's file, centres at integers. docs/backdrops.md has all of it."),
        object_of(
            "intrinsics",
            "The pinhole camera in pixels. Pixel centres are at integer coordinates (OpenCV): cx = (width - 1) / 2 "
            "is the middle."),
        object_of("lens",
                  "Models and coefficients as in OpenCV and ROS. The field of view or the intrinsics are those of the "
                  "camera's pinhole part; a fisheye needs intrinsics (fx is pixels per radian on its axis). Pixels "
                  "beyond the fold of a lens are black; their depth is infinite, their ids and normals 0. Depth is "
                  "metres along the optical axis also beyond 90 deg from it, where it is negative."),
        object_of("controls",
                  "What the camera's electronics do to the finished picture; the defaults change nothing and cost "
                  "nothing. Users of a /dev/videoN find them as V4L2 controls."),
        object_of(
            "outputs",
            "One element of outputs: where pictures go beside HTTP, which every camera has. A key belongs to some "
            "kinds only; with others it is an error."),
    };
}

std::string_view protocol_introduction() {
    return R"md(# Control protocol

<!-- Made from the tables of methods and parameters by: camrig methods --write . -->

[JSON-RPC 2.0](https://www.jsonrpc.org/specification), one JSON object a line, on

* the **Unix socket**: `--control PATH`, else `$CAMRIG_CONTROL`, else `$XDG_RUNTIME_DIR/camrig.sock`, else
  `/tmp/camrig-$UID.sock` (mode 0600);
* **TCP**, with `--tcp PORT`;
* **HTTP**, as the body of `POST /rpc`.

```
$ echo '{"jsonrpc":"2.0","id":1,"method":"world.step","params":{"seconds":0.2}}' | nc -U -q 2 /tmp/camrig-$UID.sock
```

`camrig call METHOD JSON` does the same, and `camrig methods` lists the methods.

* Parameters go by name; an unknown one is an error. `id` is a string, a number or null; a request without one is a
  notification and gets no answer. Batches are answered as one array.
* Requests on one connection are answered in their order, and the world applies commands in that order. A client may send
  ahead without waiting. The last line before the end of a connection needs no line end.
* A reply to a command that changes the world carries `applied_ns`: the world time from which it shows.
* All times are integer nanoseconds. `world_ns` and `time_ns` count from the loading of the scene.

## Errors

`error.code` is JSON-RPC's, `error.data.kind` is what programs act on, `error.message` says what to do.

| code | |
|---|---|
| -32700 | not JSON (also: nested too deep, or a key twice) |
| -32600 | not a request |
| -32601 | no such method |
| -32602 | the parameters are wrong: kind `invalid_argument` |
| -32000 | all others: see the kind |

| kind | |
|---|---|
| `invalid_argument` | a value is wrong; the message names it by its JSON path |
| `not_found` | no such camera, place, file or method |
| `already_exists` | the name is taken |
| `unavailable` | not now: the world runs or stands still, a reader holds a step up, a time limit has passed |
| `unsupported` | this rig cannot do it |
| `resource_exhausted` | a limit is reached |
| `unauthorized` | a token or key is missing or wrong, or the rig takes no commands here; the message says what to do |
| `internal` | a bug in camrig |

## Who may command

The user who started the rig, without being asked; on the **Unix socket** nobody else gets in (mode 0600), and clients send
nothing to a socket that another user made.

| | looking | commanding |
|---|---|---|
| Unix socket | its owner | its owner |
| loopback HTTP | open: page, streams, `GET`, and methods marked *open to all who may look* | the rig's **key** |
| loopback TCP | the key | the key |
| with `--token-file FILE`, a must when `--host` is not loopback | the **token** | the token |
| `--read-only` | as above; TCP asks for no key | on the Unix socket only |
| `--open-loopback`, for containers and machines of one user | open | open |

The rig makes a new key at every start and writes it into its private folder, mode 0600:
`$XDG_RUNTIME_DIR/camrig/127.0.0.1:8080.key`, else `/tmp/camrig-$UID/127.0.0.1:8080.key`, one for each address and port
(`key_file` of `server.info`). It is locked (`flock`) while the rig lives; what a killed rig left is not believed, and the
next rig removes it. Clients of the same user (Python, C++, `camrig --control HOST:PORT`) read it by themselves,
and the link that `camrig serve` prints brings it to the web page. By hand:

```
$ key=$(cat /tmp/camrig-$UID/127.0.0.1:8080.key)
$ curl -H "Authorization: Bearer $key" -H 'Content-Type: application/json' \
       -d '{"jsonrpc":"2.0","id":1,"method":"world.pause"}' http://127.0.0.1:8080/rpc
```

TCP connections begin with the token or the key,

```json
{"jsonrpc":"2.0","id":0,"method":"auth","params":{"token":"..."}}
```

and are closed when it is wrong (answered after 0.25 s, and told in the log) or anything else comes first. Of scene files outside the folder of the rig's scene,
`world.load` tells clients of the network only that they cannot be loaded; the reason is in the rig's log.

)md";
}

}  // namespace camrig::control
