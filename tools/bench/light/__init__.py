"""Pictures beside those of a path tracer. Its environment has no camrig: the package is that of this checkout."""

import sys

from tools.bench import report

sys.path.insert(0, str(report.REPOSITORY / "control" / "python"))
