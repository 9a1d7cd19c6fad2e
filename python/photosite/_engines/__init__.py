"""Data sets on several processes of this machine.

`run.py` finds the frames that are missing and makes a plan of them: of frames (`plan.py`), or of samples
(`sample_plan.py`), for which there are folders of parts (`parts.py`). The driver, which is the caller's process, gives
the plan's tasks to workers and starts those anew that die (`driver.py`). Workers write images where they belong, and
answer with what failed (`worker.py`). `task.py` has what passes between the two.
"""
