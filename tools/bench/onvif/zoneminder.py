"""ZoneMinder's own ONVIF probe and its control script, unmodified, with a camera of camrig: see README.md."""

from __future__ import annotations

import argparse
import os
import pathlib
import subprocess
import time

from client_bench import TOKEN, dome, end, verdict

# What the control script has around it in ZoneMinder: log, settings and database. All that it gets from them is a row of the table of monitors.
CONTROL = r"""
use strict; use warnings;
BEGIN { $INC{"ZoneMinder/$_.pm"} = 1 for qw(Logger Config Base Control) }
package ZoneMinder::Logger; use base 'Exporter';
our @EXPORT_OK = qw(Debug Info Error); our %EXPORT_TAGS = (all => [@EXPORT_OK]);
sub Debug {} sub Info {} sub Error { print "ERROR $_[0]\n" }
package ZoneMinder::Config; use base 'Exporter'; our %EXPORT_TAGS = (all => []);
package ZoneMinder::Base; sub ZM_VERSION { '1.36' }
package ZoneMinder::Control;
sub new { bless {}, shift } sub printMsg {} sub loadMonitor { $_[0]{Monitor} = $main::monitor }
sub getParam { $_[1]{$_[2]} }
package main;
my ($address, $device, $stop_us, $command, %given) = @ARGV;
our $monitor = {ControlAddress => $address, ControlDevice => $device, AutoStopTimeout => $stop_us};
require ZoneMinder::Control::onvif;
my $control = ZoneMinder::Control::onvif->new();
$control->open();
$control->$command(\%given);
"""


def drive(cam, port, source):
    architecture = source / "usr/lib/x86_64-linux-gnu"
    paths = [source / "usr/share/perl5", *architecture.glob("perl5/*")]
    environment = dict(os.environ, PERL5LIB=":".join(map(str, paths)), LD_LIBRARY_PATH=str(architecture))

    def perl(*arguments):
        done = subprocess.run(["perl", *map(str, arguments)], env=environment, capture_output=True, text=True, timeout=60, check=False)
        return done.stdout + done.stderr

    def control(command, *given, device="dome", stop_us=0):
        return perl("-e", CONTROL, f"camrig:{TOKEN}@127.0.0.1:{port}/onvif/device_service", device, stop_us, command, *given)

    def pan():
        """Where the head comes to a stand, in degrees, positive to the left."""
        time.sleep(0.3)  # its latency
        while (status := cam.ptz.status())["turning"] or status["zooming"]:
            time.sleep(0.02)
        return round(status["pan_deg"], 2)

    probe = source / "usr/bin/zmonvif-probe.pl"
    service = f"http://127.0.0.1:{port}/onvif/device_service"
    for version in ("1.1", "1.2"):
        lines = perl(probe, "profiles", service, version, "camrig", TOKEN).splitlines()
        uris = [line.split(", ")[-1] for line in lines if ", RTP-Unicast, " in line]
        verdict(f"zmonvif-probe.pl profiles, SOAP {version}", uris == [cam.url(name) for name in ("rtsp", "rtsp-sub", "rtsp-mjpeg")], lines[:1])
    verdict("with a wrong password", perl(probe, "profiles", service, "1.2", "camrig", "wrong").startswith("No result"))

    verdict("presetSet 1, where there is none of that name", "NoToken" in control("presetSet", "preset", 1), "refused, as the standard wants it")
    cam.ptz.preset_set("1")
    said, right = control("moveConRight", stop_us=500_000), pan()
    verdict("moveConRight, ended by the auto stop of 0.5 s", not said and -40 < right < -10, said or right)
    said = control("presetSet", "preset", 1)
    verdict("presetSet 1, which it puts elsewhere", not said and abs(cam.ptz.status()["presets"]["1"]["pan_deg"] - right) < 0.1, said[:300])
    for command, given, wanted in (("presetHome", (), 0), ("presetGoto", ("preset", 1), right)):
        said, there = control(command, *given), pan()
        verdict(command, not said and abs(there - wanted) < 0.1, said[:300] or there)
    said = control("moveConLeft")
    time.sleep(1)
    verdict("moveConLeft without auto stop goes on", not said and cam.ptz.status()["turning"] and cam.ptz.status()["pan_deg"] > right, said[:300])
    said, there = control("moveStop"), pan()
    verdict("until moveStop", not said and there < 90, said[:300] or there)
    control("zoomConTele", stop_us=300_000)
    pan()
    verdict("zoomConTele, ended by its auto stop", 1.1 < (zoom := cam.ptz.status()["zoom"]) < 20, round(zoom, 2))
    verdict("the profile 000, where none is typed", "NoProfile" in control("moveStop", device=""), "refused: there is no such profile")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("source", type=pathlib.Path, help="where Debian's zoneminder and the Perl packages it wants were unpacked by dpkg -x")
    arguments = parser.parse_args()
    with dome((320, 240)) as (_, cam, port):
        drive(cam, port, arguments.source.resolve())
    end()


if __name__ == "__main__":
    main()
