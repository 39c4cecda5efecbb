"""The engine: every item once, whatever becomes of workers; and they end with whoever began them."""

from __future__ import annotations

import logging
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from retrodict.studies.engine import Engine, NoScheduler, WorkerDied, engine
from tests.studies import jobs

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def two() -> Iterator[Engine]:
    """Two workers; begun once, and this process is afterwards as it was."""
    import distributed  # noqa: F401  which sets its loggers up

    before = dict(os.environ), logging.getLogger("distributed").level
    with engine(2) as made:
        yield made
    assert (dict(os.environ), logging.getLogger("distributed").level) == before


@pytest.fixture(params=["this process", "two workers"])
def running(request: pytest.FixtureRequest) -> Engine:
    return Engine(None) if request.param == "this process" else request.getfixturevalue("two")


def test_every_item_comes_once_and_so_does_what_it_brings(running: Engine) -> None:
    def more(number: int, square: int | WorkerDied) -> list[int]:
        assert square == number**2
        return [10 * number, 10 * number + 1] if 0 < number < 10 else []

    found = list(running.each(jobs.squared, range(5), more))
    numbers = [*range(5), *(10 * i + j for i in range(1, 5) for j in (0, 1))]
    assert sorted(found) == [(i, i**2) for i in sorted(numbers)]


def test_what_a_job_raises_ends_the_run(running: Engine) -> None:
    with pytest.raises(ZeroDivisionError, match="of 1"):
        list(running.each(jobs.refusing, [1]))


def test_only_the_task_that_ends_its_worker_each_time_is_given_up(two: Engine) -> None:
    found = dict(two.each(jobs.deadly, range(8)))
    assert isinstance(found.pop(3), WorkerDied)
    assert found == {i: i for i in range(8) if i != 3}


def test_the_task_of_a_worker_that_is_killed_is_done_again(two: Engine, tmp_path: Path) -> None:
    file = tmp_path / "died"
    ((_, by),) = two.each(jobs.deadly_once, [file])
    assert file.exists()
    assert by != os.getpid()


def test_workers_listen_on_the_loopback_address_alone(two: Engine) -> None:
    ((_, addresses),) = two.each(jobs.listening, [0])
    assert addresses == {"127.0.0.1"}


def test_a_worker_has_one_core(two: Engine) -> None:
    ((_, cores),) = two.each(jobs.cores, [0])
    assert cores == 1


@pytest.mark.slow
def test_an_address_without_a_scheduler_is_named() -> None:
    unused = "tcp://127.0.0.1:9"
    with pytest.raises(NoScheduler, match=f"{unused}: nothing answers"), engine(None, unused):
        pass


@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGKILL, marks=pytest.mark.slow)]
)
def test_workers_end_with_the_process_that_began_them(tmp_path: Path, number: int) -> None:
    """By Ctrl-C, which a terminal sends to all of them, without a word of theirs."""
    script = tmp_path / "parent.py"
    script.write_text(
        "import time\n"
        "from retrodict.studies.engine import engine\n"
        "if __name__ == '__main__':\n"
        "    try:\n"
        "        with engine(2) as running:\n"
        "            for _ in running.each(time.sleep, [0] + 1000 * [0.5]):\n"
        "                print('one', flush=True)\n"
        "    except KeyboardInterrupt:\n"
        "        print('interrupted')\n"
    )
    with subprocess.Popen(
        [sys.executable, script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    ) as parent:  # fmt: skip
        assert parent.stdout is not None
        assert parent.stdout.readline() == "one\n"
        workers = psutil.Process(parent.pid).children(recursive=True)
        assert len(workers) >= 2
        (os.killpg if number == signal.SIGINT else os.kill)(parent.pid, number)
        out, error = parent.communicate(timeout=60)
        _, alive = psutil.wait_procs(workers, timeout=30)
        assert not alive
    if number == signal.SIGINT:
        assert out.splitlines()[-1] == "interrupted"
        assert not error
