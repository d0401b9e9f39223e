"""The command ``hsr``, one file a verb."""

from __future__ import annotations

import signal
import sys

INTERRUPTED = 130
"""Exit code after Ctrl-C."""


def main() -> None:
    """Run the command. Ctrl-C is heard from the first import on, and ends it in one line."""
    heard: list[int] = []

    def hear(number: int, _frame: object) -> None:
        heard.append(number)
        started = sys.modules.get("multiprocessing.process")
        for child in started.active_children() if started else ():
            child.terminate()  # it would be waited for
        raise KeyboardInterrupt

    def tell(kind: type[BaseException], *error: object) -> None:
        if not heard:
            sys.__excepthook__(kind, *error)  # type: ignore[arg-type]

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, hear)
    # Modules in C print what interrupts their import, and go on with an error of theirs.
    sys.excepthook = tell
    try:
        from hsr.cli.app import main as run

        run(heard)
    except BaseException:
        if not heard:
            raise
        print("hsr: interrupted", file=sys.stderr)
        sys.exit(INTERRUPTED)
