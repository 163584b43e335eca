"""``python -m usd_tailor`` is the command ``usdtailor``."""

from ._command import main

main()
