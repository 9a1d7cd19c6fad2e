"""A worker process of the local engine: tasks come on standard input, answers go to standard output, a line each."""

from __future__ import annotations

import json
import os
import queue
import sys
import threading
from typing import Any

from .work import carry_out

__all__ = ["main"]


def main() -> None:
    """Works until there is nothing more to come."""
    # What else is printed must not come between answers.
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    tasks: "queue.Queue[dict[str, Any]]" = queue.Queue()
    threading.Thread(target=_listen, args=(tasks,), daemon=True).start()
    print('{"ready": true}', file=answers, flush=True)
    while True:
        asked = tasks.get()
        print(json.dumps(carry_out(asked["job"], asked["task"])), file=answers, flush=True)


def _listen(tasks: "queue.Queue[dict[str, Any]]") -> None:
    for line in sys.stdin:
        tasks.put(json.loads(line))
    # The driver has done, or is dead: nobody waits for what is under way.
    os._exit(0)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        # The picture under way has left a checkpoint.
        sys.exit(130)
