"""The page of a sweep: tables that sort and diagrams, as the report has them."""

from __future__ import annotations

from collections.abc import Sequence

from app.report.page import page
from app.sweeps.plan import SweepRecord
from app.sweeps.sections import sections
from app.sweeps.table import Row


def sweep_page(record: SweepRecord, table: Sequence[Row], title: str) -> str:
    machines = sorted({str(row.costs.get("machine")) for row in table if row.costs})
    facts = {"sweep": title, "task": record.task, "machines": "; ".join(machines)}
    return page(sections(record, table), facts, title="VesselSplat sweep")
