"""A network of smart cameras on a rig: runs it live, compares strategies on what its cameras saw, and writes a report.

    python -m examples.network                          # 8 cameras and 2 heads in lockstep, then all strategies
    python -m examples.network --quick                  # 3 cameras and 1 head for 4 s
    python -m examples.network --mode realtime --cameras 3 --heads 0 --fps 2
    python -m examples.network --replay network-run     # the comparisons again, on a recorded run

docs/network.md is the tutorial.
"""

from __future__ import annotations

import argparse
import signal
import sys
from pathlib import Path
from typing import Any, NoReturn, Sequence

import camrig
from camrig.command_line import run as run_command

from . import camsim, report, stage
from .conductor import Conductor
from .nodes import Plan
from .score import read_logs, score
from .sweep import ALL, Recording, sweep


def progress(what: str, number: int, of: int) -> None:
    """One line that is written over."""
    print(f"\r{what} {number} of {of} ", end="\n" if number == of else "", file=sys.stderr, flush=True)


def _end(*_: Any) -> NoReturn:
    """SIGTERM ends the programs, the server and the rig as Ctrl-C does."""
    raise SystemExit("ended by SIGTERM")


def live(options: argparse.Namespace) -> dict[str, Any]:
    """Runs the network; the score of what its programs logged."""
    signal.signal(signal.SIGTERM, _end)
    is_lockstep = options.mode == "lockstep"
    with camrig.start(options.scene, mode=options.mode, seed=options.seed, overload=None if is_lockstep else "slow") as rig:
        cameras, heads = stage.build(rig, options.cameras, options.heads, options.fps)
        plan = Plan(cameras, heads, options.strategy, options.rounds, options.loss, options.seed, options.fps)
        is_device = is_lockstep or options.source == "device"
        steps = max(1, round(options.seconds * options.fps))
        ended = Conductor(rig, plan, options.out, is_device, lambda number, of, _: progress("step", number, of)).run(steps)
    for name, code in sorted(ended.items()):
        print(f"{name} ended early with {code}; {options.out}/{name}.err may say why", file=sys.stderr)
    recording = Recording(options.out)
    return score(recording.truth, read_logs(options.out, plan.names()), plan.cameras, plan.heads)


def about(plan: Plan, mode: str) -> str:
    return (f"{len(plan.cameras)} cameras, {len(plan.heads)} heads, strategy {plan.strategy}, {plan.rounds} rounds of consensus, {plan.loss:.0%} of messages lost, "
            f"a picture each {plan.period_s * 1e3:.4g} ms, seed {plan.seed}, {mode}")


def main(arguments: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m examples.network", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="hall", help="a scene file or the name of a shipped one (default hall, for which cameras.json has places)")
    parser.add_argument("--cameras", type=int, default=8, help="fixed cameras (default 8)")
    parser.add_argument("--heads", type=int, default=2, help="cameras on heads (default 2)")
    parser.add_argument("--seconds", type=float, default=40.0, help="of world time (default 40)")
    parser.add_argument("--fps", type=float, default=4.0, help="pictures a second of each camera (default 4)")
    parser.add_argument("--strategy", choices=ALL, default="ASM", help="CamSim's six, none or central (default ASM)")
    parser.add_argument("--rounds", type=int, default=0, help="of the consensus filter a step (default 0: no filter; lockstep only)")
    parser.add_argument("--loss", type=float, default=0.0, help="share of messages that links lose (default 0)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seeds", type=int, default=3, help="of the comparisons, whose means are shown (default 3)")
    parser.add_argument("--mode", choices=("lockstep", "realtime"), default="lockstep")
    parser.add_argument("--source", choices=("device", "rtsp"), help="what the programs open (default: device in lockstep, else rtsp)")
    parser.add_argument("--out", type=Path, default=Path("network-run"), help="folder (default network-run)")
    parser.add_argument("--replay", type=Path, metavar="FOLDER", help="no run: compare on a recorded one")
    parser.add_argument("--no-sweep", action="store_true", help="the run alone")
    parser.add_argument("--quick", action="store_true", help="3 cameras, 1 head, 4 s, no comparisons")
    options = parser.parse_args(arguments)
    if options.quick:
        options.cameras, options.heads, options.seconds, options.no_sweep = 3, 1, 4.0, True
    if not 0 <= options.loss < 1 or not 0 <= options.rounds <= 50 or options.fps <= 0 or options.seconds <= 0 or options.seeds < 1:
        parser.error("--loss is 0 to below 1, --rounds 0 to 50, --fps and --seconds are above 0, --seeds is 1 or more")
    if options.mode == "realtime" and options.rounds:
        parser.error("--rounds needs lockstep: rounds of consensus have a common beat")
    if options.mode == "lockstep" and options.source == "rtsp":
        parser.error("--source rtsp needs real time: a decoder holds pictures back, for which lockstep would wait")
    if options.mode == "realtime" and options.heads and options.source != "device":
        parser.error("heads are turned by the controls of their devices: --source device, or --heads 0")

    options.out = options.replay or options.out
    options.out.mkdir(parents=True, exist_ok=True)
    if options.replay:
        recording = Recording(options.replay)
        results: dict[str, Any] = {"run": recording.score(recording.plan), "about": about(recording.plan, "replayed")}
    else:
        results = {"run": live(options)}
        recording = Recording(options.out)
        results["about"] = about(recording.plan, options.mode)
    if not options.no_sweep and options.mode == "lockstep":
        results["sweeps"] = sweep(options.out, options.seeds, lambda number, of: progress("comparison", number, of))
        results["camsim"] = camsim.table()
    print(report.write(options.out, results))
    return 0


if __name__ == "__main__":
    sys.exit(run_command(main))
