"""The short ones of tests/attack, which speak the rig's protocols by themselves: they are still spoken, and stood."""

import subprocess
import sys
from pathlib import Path

RUN = Path(__file__).parents[1] / "attack" / "run.py"
SHORT = ("garbage_for_devices", "descriptors_for_devices", "programs_with_control_characters", "numbers_at_their_bounds", "digests_again",
         "a_stranger_commands_over_http", "paths_out_of_the_tree", "pages_of_other_origins")


def test_the_rig_stands_the_short_attacks():
    done = subprocess.run([sys.executable, RUN, *(word for name in SHORT for word in ("-k", name))], capture_output=True, text=True, timeout=200)
    lines = done.stdout.splitlines()
    assert done.returncode == 0 and lines[-1] == "all stood", done.stdout + done.stderr
    assert {line.split()[1] for line in lines if line.startswith("stood")} >= set(SHORT), done.stdout
