"""Who waits for the folder of recordings: one look for all who ask the same, and no one behind long ones."""

import asyncio
import threading
from collections.abc import Callable, Iterator
from typing import Any, cast

import pytest

from controller.errors import TendrilError
from recordings.store.store import Store
from server.recorder.folder import LOOKERS, Reader, RecordingsFolder


class SlowReader:
    """Answers when it may."""

    def __init__(self) -> None:
        self.may = threading.Event()
        self.asked: list[tuple[Any, ...]] = []

    def call(self, work: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
        self.asked.append(arguments)
        assert self.may.wait(10.0)
        return work(*arguments, **named)


@pytest.fixture
def reader() -> Iterator[SlowReader]:
    found = SlowReader()
    yield found
    found.may.set()


@pytest.fixture
def folder(reader: SlowReader) -> Iterator[RecordingsFolder]:
    found = RecordingsFolder(cast(Store, None), cast(Reader, reader))
    yield found
    found.close()


def words(*parts: object) -> str:
    return " ".join(map(str, parts))


def fail(*parts: object) -> str:
    raise TendrilError("no")


async def test_who_asks_the_same_while_it_is_under_way_waits_for_the_same_answer(
    folder: RecordingsFolder, reader: SlowReader
) -> None:
    same = [asyncio.create_task(folder.quick_for_all(words, "a", 2000, ())) for _ in range(3)]
    other = asyncio.create_task(folder.quick_for_all(words, "b", 2000, ()))
    await asyncio.sleep(0.05)
    same[0].cancel()
    reader.may.set()
    assert await asyncio.gather(*same[1:], other) == ["a 2000 ()", "a 2000 ()", "b 2000 ()"]
    assert sorted(reader.asked) == [("a", 2000, ()), ("b", 2000, ())]
    await folder.quick_for_all(words, "a", 2000, ())
    assert len(reader.asked) == 3, "a recording grows: who asks later gets a look of their own"


async def test_an_error_is_everybodys_and_not_kept(folder: RecordingsFolder, reader: SlowReader) -> None:
    reader.may.set()
    for _ in range(2):
        same = await asyncio.gather(*(folder.quick_for_all(fail, "a") for _ in range(2)), return_exceptions=True)
        assert [str(error) for error in same] == ["no", "no"]
    assert len(reader.asked) == 2


async def test_what_only_looks_at_the_folder_does_not_wait_behind_long_quick_looks(
    folder: RecordingsFolder, reader: SlowReader
) -> None:
    long = [asyncio.create_task(folder.quick(words, number)) for number in range(LOOKERS)]
    long += [asyncio.create_task(folder.quick_for_all(words, number)) for number in range(LOOKERS)]
    await asyncio.sleep(0.05)
    assert await asyncio.wait_for(folder.look(words, "found"), 5.0) == "found"
    reader.may.set()
    await asyncio.gather(*long)
