"""What v4l2-compliance has to say of a device."""

import re


def complaints(report: str) -> list[str]:
    """Failures and warnings of a whole report, but for numbers of frames that are left out: it was too slow to read them, which is no fault of the device's."""
    assert re.search(r"Total for camrig device \S+: \d+, Succeeded: \d+, Failed: \d+, Warnings: \d+", report), report[-3000:]
    return [line for line in report.splitlines() if re.search(r"\b(fail|warn):", line) and "got sequence number" not in line]
