"""What the reader wants to know first: the bars and whether they are met, then where the numbers come from."""

import os
import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from markupsafe import Markup

from controller.research.experiments.results import Results
from controller.research.report.bars import bars
from controller.research.report.fitted import provenance
from controller.text.document import joined, table


def headline(results: Results, fit: Mapping[str, Any]) -> Markup:
    """Bars as a list, facts as a table."""
    items = joined(Markup("<li>{}</li>").format(one) for one in (*bars(results), failures(results)))
    facts = [*provenance(fit), *circumstances(results)]
    return Markup("<ul>{}</ul>{}").format(items, table(("", ""), facts, ()))


def failures(results: Results) -> str:
    """How many runs did not come to their end."""
    count = len(results.failures)
    return f"{count} of {results.runs} runs failed; see below." if count else "No run failed."


def failed_runs(results: Results) -> Markup:
    """All runs that did not come to their end, with their sentences."""
    rows = [
        (f"{case.reference}, {case.actuator}, {case.law}", str(case.seed), one.sentence)
        for one in results.failures
        for case in (one.case,)
    ]
    return table(("run", "seed", "why"), rows)


def circumstances(results: Results) -> list[tuple[str, str]]:
    """When, where and with which seeds."""
    cores = os.cpu_count() or 1
    return [
        ("run", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC") + (", quick: each once" if results.quick else "")),
        ("machine", f"{processor()}, {cores} cores; Python {platform.python_version()}, {platform.system()}"),
        (
            "time",
            f"{results.seconds:.0f} s with {results.workers} process{'es' * (results.workers > 1)}, this page excluded",
        ),
        ("seeds", ", ".join(map(str, results.seeds))),
    ]


def processor() -> str:
    """Name of the processor, as far as the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return next(iter(named), platform.processor() or platform.machine())
