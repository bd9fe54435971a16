"""The numbers of tests/farm/live.py, as docs/farm.md has them."""

from __future__ import annotations

from typing import Any


def page_part(found: dict[str, Any]) -> str:
    parts = []
    if one := found.get("lockstep"):
        parts.append(f"**Lockstep**: {one['nodes']} nodes, {one['cameras']} cameras of 160x120 in `hall`, {one['commands']} random commands of 3 clients in {one['seconds']:.0f} s, {one['steps']} steps. "
                     f"At {one['checks']} checks the state of all nodes was equal; of {one['pictures']} pictures {one['different_pictures']} are not those of one machine that does the log again.")
    if one := found.get("disturbed"):
        parts.append(f"The same for {one['seconds']:.0f} s while a node is killed, the sequencer's node is killed, a node stops for 5 s and a node's link is down for 5 s: "
                     f"{one['commands']} commands taken, of {one['pictures']} pictures {one['different_pictures']} differ. The longest step took {one['slowest_step_s']:.1f} s.")
    if one := found.get("realtime"):
        lines = [f"**Real time**: 4 nodes, {one['cameras']} cameras at {one['fps']} fps, an MJPEG reader on each, which asks the farm for its camera's address when its connection ends or brings nothing new for 1 s.", "",
                 "| | times | away, median | 99th percentile | frames that readers of that node missed | of other nodes: frames missed, connections lost, longest wait |", "|---|---|---|---|---|---|"]
        for name, case in one["cases"].items():
            lines.append(f"| {name} | {case['times']} | {case['median_s']} s | {case['p99_s']} s | {case['lost']} of {case['cameras']} cameras | {case['healthy_lost']}, {case['healthy_reconnects']}, {case['healthy_gap_s']} s |")
        slow = one["slow"]
        lines += ["", f"A node whose rig runs a fiftieth of the time for {slow['seconds']:.0f} s: its readers missed {slow['lost']} frames, those of others {slow['healthy_lost']}. "
                  + "; ".join(f"a clock {name} by 300 ms was told as {clock['told_ms']:+.2f} ms within {clock['bound_ms']:.2f} ms" for name, clock in one["clocks"].items()) + "."]
        parts.append("\n".join(lines))
    if one := found.get("cost"):
        idle, busy = one["farm"]["0"], one["farm"]["100"]
        lines = ["**Cost**, milliseconds of CPU a second, `minimal`, nobody watching; `node` is its Python, `rig` the daemon; the log's is what 100 commands/s take beyond what they take one rig alone:", "",
                 "| | no commands | 100 commands/s | the log's | no commands vary by |", "|---|---|---|---|---|"]
        alone = one["alone"]
        lines.append(f"| one rig alone | {alone['0']['rig']} | {alone['100']['rig']} | - | {alone['spread']['rig']} |")
        lines += [f"| {name} | {idle[name]} | {busy[name]} | {one['log_ms'][name]} | {one['farm']['spread'][name]} |" for name in sorted(idle)]
        parts.append("\n".join(lines))
    return "\n\n".join(parts)
