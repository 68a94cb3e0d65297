"""Stiff and extreme cases of the enhancement: python -m tests.benchmarks.enhance_stability"""

from __future__ import annotations

import sys

from enhance.stability import stability
from tests.enhance.pictures import vessels


def main() -> None:
    rows = list(stability(vessels(240, 320)))
    for row in rows:
        verdict = "pass" if row.passed else "FAIL"
        sys.stdout.write(
            f"{verdict}  {row.hazard:26}{row.case:48}{row.measured:12.3g} <= {row.bar:<10.3g}{row.unit}\n"
        )
    failed = sum(not row.passed for row in rows)
    sys.stdout.write(f"{len(rows)} cases, {failed} failed\n")
    raise SystemExit(1 if failed else 0)


if __name__ == "__main__":
    main()
