"""The examples of docs/actors.md run as they stand."""

import re

from conftest import REPOSITORY


def test_the_programs_of_the_guide_run(monkeypatch, capsys):
    monkeypatch.chdir(REPOSITORY)
    programs = re.findall(r"^```python\n(.*?)^```", (REPOSITORY / "docs/actors.md").read_text(), re.MULTILINE | re.DOTALL)
    assert len(programs) >= 2
    for program in programs:
        exec(compile(program, "docs/actors.md", "exec"), {"__name__": "__main__"})
    assert "abandoned" in capsys.readouterr().out
