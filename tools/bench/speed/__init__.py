"""Speed of whole rigs: runs `camrig serve` as a user would, reads it as a client would, and writes docs/speed.md.

    .venv/bin/python -m tools.bench.speed                 all of it, about 15 minutes on an idle machine
    .venv/bin/python -m tools.bench.speed --only targets  one part: targets, cameras, sizes, limits, soak
    .venv/bin/python -m tools.bench.speed --quick         a few seconds a run: to see that it works, not to quote

Nothing here is a test: the numbers are those of one machine, named in the page.
"""
