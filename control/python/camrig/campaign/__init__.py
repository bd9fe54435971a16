"""Campaigns: a table of faults and severities against a program that knows nothing of it (docs/faults.md).

    campaign = camrig.campaign.load("network", {"program": "ffmpeg -i {rtsp} -f null -", "check": {"well": "frame=", "every_s": 2}})
    with camrig.start("hall") as rig:
        report = camrig.campaign.run(rig, campaign)
    camrig.campaign.write(report, "report")
"""

from .report import write
from .runner import OUTCOMES, Report, Result, run
from .spec import Campaign, Cell, Check, Row, load, shipped_names

__all__ = ["OUTCOMES", "Campaign", "Cell", "Check", "Report", "Result", "Row", "load", "run", "shipped_names", "write"]
