#include "control/rpc/method_shapes.h"

namespace camrig {

std::vector<Shape> protocol_shapes() {
    return {
        {"pose",
         "Where a camera is and how it is turned, in the world (right-handed, z up). Give at most one of look_at, the "
         "angles "
         "and orientation; with none of them the camera looks along +x.",
         {{"position", "[x, y, z]", "where it is", true, "m"},
          {"look_at", "[x, y, z]", "the point in the middle of the picture; the horizon stays level", false, "m"},
          {"pan_deg", "number", "about world z, counter-clockwise from above; 0 looks along +x", false, "deg", "0"},
          {"tilt_deg", "number", "positive looks up", false, "deg", "0"},
          {"roll_deg", "number", "about the viewing direction, clockwise seen from behind the camera", false, "deg",
           "0"},
          {"orientation", "[x, y, z, w]", "quaternion of the body frame: x forward, y left, z up"}}},
        {"mount",
         "Fixes a camera to an actor: a vehicle, a drone, a person. `pose` is then in the frame of the mount, x ahead, "
         "y "
         "left, z up, and so is what look_at names; it moves with every picture. When the actor is removed the camera "
         "stays where it was, and follows again when an actor of this name comes.",
         {{"actor", "string", "its name", true},
          {"node", "string",
           "a node of its model: the frame is at the node and turns as the node does in its clips; at rest, one "
           "without "
           "a turn of its own has the axes of the actor. Empty: the actor's own frame, at its origin",
           false, "", "\"\""}}},
        {"intrinsics",
         "The pinhole camera in pixels. Pixel centres are at integer coordinates (OpenCV): cx = (width - 1) / 2 is the "
         "middle.",
         {{"fx", "number", "focal length", true, "px"},
          {"fy", "number", "focal length", true, "px"},
          {"cx", "number", "principal point", true, "px"},
          {"cy", "number", "principal point", true, "px"}}},
        {"lens",
         "Models and coefficients as in OpenCV and ROS. The field of view or the intrinsics are those of the camera's "
         "pinhole part; a fisheye needs intrinsics (fx is pixels per radian on its axis). Pixels beyond the fold of a "
         "lens are black; their depth is infinite, their ids and normals 0. Depth is metres along the optical axis "
         "also "
         "beyond 90 deg from it, where it is negative.",
         {{"model", "string",
           "`pinhole`, `plumb_bob` (k1 k2 p1 p2 k3), `rational_polynomial` (k1 k2 p1 p2 k3 k4 k5 k6) or `equidistant` "
           "(k1 k2 k3 k4)",
           true},
          {"coefficients", "array of numbers", "as many as the model has; pinhole has none"},
          {"method", "string",
           "what the picture is resampled from: `warp` (one larger pinhole picture), `cube` (the faces of a cube) or "
           "`auto` (what needs fewer pixels)",
           false, "", "auto"},
          {"filter", "string",
           "`bilinear`, `bicubic` (Catmull-Rom: keeps more contrast) or `auto` (bicubic at quality beautiful); "
           "ssaa "
           "always takes bilinear samples",
           false, "", "auto"},
          {"oversample", "integer", "1 to 4: source pixels per pixel, along a side, at least", false, "", "1"}}},
        {"controls",
         "What the camera's electronics do to the finished picture; the defaults change nothing and cost nothing. "
         "Users of a /dev/videoN find them as V4L2 controls.",
         {{"auto_exposure", "boolean", "the scene's exposure; off when exposure_ev is given", false, "", "true"},
          {"exposure_ev", "number", "-6 to 6: light is multiplied by 2^ev", false, "EV", "0"},
          {"gain_db", "number", "0 to 24: light is multiplied by 10^(dB/20)", false, "dB", "0"},
          {"auto_white_balance", "boolean", "neutral; off when white_balance_k is given", false, "", "true"},
          {"white_balance_k", "number", "2800 to 10000: the light that is taken for white; lower makes bluer pictures",
           false, "K", "6500"},
          {"brightness", "number", "-1 to 1, added to the sRGB codes (1: from black to white)", false, "", "0"},
          {"contrast", "number", "0 to 2, about the middle code", false, "", "1"},
          {"saturation", "number", "0 to 2; 0 is grey", false, "", "1"}}},
        {"outputs",
         "One element of outputs: where pictures go beside HTTP, which every camera has.",
         {{"kind", "string", "`v4l2`, `device`, `rtsp` or `mjpeg`", true},
          {"number", "integer", "v4l2 and device: N of /dev/videoN"},
          {"format", "string", "v4l2: `YUYV`, `YU12`, `MJPG` or `BGR3`", false, "", "YUYV"},
          {"subsampling", "string", "chroma of MJPG, of device and of v4l2 with format `MJPG`: `4:2:2` or `4:2:0`",
           false, "", "4:2:2"},
          {"codec", "string", "rtsp: `h264` or `mjpeg`", false, "", "h264"},
          {"quality", "integer", "mjpeg: 1 to 100", false, "", "90"},
          {"bitrate_kbps", "integer", "rtsp h264: 16 to 200000; by default 0.15 bits per pixel", false, "kbit/s"},
          {"key_interval_s", "number", "rtsp h264: a key frame at least so often, 0.01 to 60", false, "s", "2"},
          {"preset", "string", "rtsp h264: `ultrafast`, `superfast`, `veryfast`, `faster`, `fast`, `medium` or `slow`",
           false, "", "superfast"},
          {"profile", "string", "rtsp h264: `baseline`, `main` or `high`", false, "", "main"}}},
    };
}

std::string_view protocol_introduction() {
    return R"md(# Control protocol

<!-- Made from the method table by: camrig methods --markdown > docs/control-protocol.md -->

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
(`key_file` of `server.info`). Clients of the same user (Python, C++, `camrig --control HOST:PORT`) read it by themselves,
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

}  // namespace camrig
