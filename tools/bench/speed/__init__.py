"""Speed of whole rigs: runs `camrig serve` as a user would, reads it as a client would, and writes docs/speed.md.

    .venv/bin/python -m tools.bench.speed                  all of it, about half an hour on an idle machine
    .venv/bin/python -m tools.bench.speed --only targets   one part; may come more than once
    .venv/bin/python -m tools.bench.speed --quick          a few seconds a run: to see that it works, not to quote
    .venv/bin/python -m tools.bench.speed --only soak --soak-minutes 30

Figures need matplotlib (tools/bench/speed/requirements.txt). Kernels are measured by `camrig_kernels`, which is built with
`cmake --preset dev -DCAMRIG_BENCHMARKS=ON`; other renderers by tools/bench/peers. What is not there is left out, and
the page says so. Nothing here is a test: the numbers are those of one machine, named in the page.
"""

from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[3]
