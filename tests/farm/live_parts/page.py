"""The numbers of tests/farm/live.py, as docs/farm.md has them."""

from __future__ import annotations

from typing import Any


def page_part(found: dict[str, Any]) -> str:
    parts = []
    if one := found.get("lockstep"):
        parts.append(f"**Lockstep** (commit {one['commit']}): {one['nodes']} nodes, {one['cameras']} cameras of 160x120 in `hall`, {one['commands']} random commands of 3 clients "
                     f"in {one['seconds']:.0f} s, {one['steps']} steps. {_lockstep_result(one)}")
    if one := found.get("disturbed"):
        slowest = "; ".join(f"{what}: {seconds:.1f} s" for what, seconds in one["slowest_step_s"].items())
        parts.append(f"The same for {one['seconds']:.0f} s with {one['commands']} commands and three NATS servers (commit {one['commit']}), while things are done to it. "
                     f"{_lockstep_result(one)} The longest step, after {slowest}.")
    if one := found.get("realtime"):
        lines = [f"**Real time** (commit {one['commit']}): 4 nodes, {one['cameras']} cameras at {one['fps']} fps, an MJPEG reader on each, which asks the farm for its camera's "
                 "address when its connection ends or brings nothing new for 1 s.", "",
                 "| | times | a camera is away, median | 99th percentile | its readers missed | readers of other nodes missed (beyond `overload` and `held`) | and lost connections | longest wait of theirs |",
                 "|---|---|---|---|---|---|---|---|"]
        for name, case in one["cases"].items():
            lines.append(f"| {name} | {case['times']} | {case['median_s']} s | {case['p99_s']} s of {case['cameras']} | {case['lost']} frames | {case['healthy_lost']} frames "
                         f"| {case['healthy_reconnects']} | {case['healthy_gap_s']} s |")
        slow = one["slow"]
        clocks = "; ".join(f"a clock 300 ms {name} was told as {clock['told_ms']:+.2f} ms within {clock['bound_ms']:.2f} ms" for name, clock in one["clocks"].items())
        lines += ["", f"A node whose rig runs a fiftieth of the time for {slow['seconds']:.0f} s: its readers missed {slow['lost']} frames, those of others {slow['healthy_lost']}; {clocks}."]
        parts.append("\n".join(lines))
    if one := found.get("bus"):
        lines = [f"**NATS servers killed** (commit {one['commit']}): 3 nodes, {one['cameras']} cameras at {one['fps']} fps, `minimal`, a client that sends a command when the last is "
                 f"answered; the only server is started again after {one['down_s']:.0f} s.", "",
                 "| | times | longest wait for a command, median | most | longest wait for a picture, median | most | readers missed | and lost connections |",
                 "|---|---|---|---|---|---|---|---|"]
        lines += [f"| {name} | {case['times']} | {case['command_median_s']} s | {case['command_most_s']} s | {case['picture_median_s']} s | {case['picture_most_s']} s "
                  f"| {case['missed']} frames | {case['connections']} |" for name, case in one["cases"].items()]
        parts.append("\n".join(lines))
    if one := found.get("cost"):
        idle, busy = one["farm"]["0"], one["farm"]["100"]
        lines = [f"**Cost** (commit {one['commit']}), milliseconds of CPU a second, `minimal`, nobody watching; `node` is its Python, `rig` the daemon; the log's is what 100 commands/s "
                 "take beyond what they take one rig alone:", "",
                 "| | no commands | 100 commands/s | the log's | no commands vary by |", "|---|---|---|---|---|"]
        alone = one["alone"]
        lines.append(f"| one rig alone | {alone['0']['rig']} | {alone['100']['rig']} | - | {alone['spread']['rig']} |")
        lines += [f"| {name} | {idle[name]} | {busy[name]} | {one['log_ms'][name]} | {one['farm']['spread'][name]} |" for name in sorted(idle)]
        parts.append("\n".join(lines))
    return "\n\n".join(parts)


def _lockstep_result(one: dict[str, Any]) -> str:
    return (f"At {one['unequal_checks']} of {one['checks']} checks the states of the nodes were unequal; {one['different_pictures']} of {one['pictures']} pictures are not those of one "
            f"machine that does the log again, and {one['wrong_stamps']} have another's stamp.")
