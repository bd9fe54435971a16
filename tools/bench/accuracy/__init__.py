"""The accuracy of camrig's cameras, measured through its public doors against OpenCV in double precision.

    python tools/bench/accuracy [--quick] [PART...]     measures and writes docs/accuracy.md and docs/pictures/accuracy

The tests (tests/system/test_accuracy*.py) use the same modules with gates.
"""

import pathlib
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
for folder in (".", "tools/assets", "control/python"):
    if str(REPOSITORY / folder) not in sys.path:
        sys.path.append(str(REPOSITORY / folder))
