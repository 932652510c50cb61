import threading

import numpy as np
import pytest

from controller.arrays import Words
from controller.realtime.compiled import compiled
from controller.realtime.mailbox import mailbox, post, receive, words
from controller.schema.layout import record_dtype
from controller.schema.messages import Command

pytestmark = pytest.mark.alone


@compiled
def post_many(box: Words, record: Words, count: int) -> None:
    for k in range(1, count + 1):
        record[:] = k
        post(box, record)


@compiled
def receive_until(box: Words, last: int, scratch: Words, record: Words) -> tuple[int, int]:
    seen = mixed = taken = 0
    while record[0] != last:
        sequence = receive(box, seen, scratch, record)
        taken += sequence != seen
        seen = sequence
        for i in range(record.shape[0]):
            mixed += record[i] != record[0]
    return mixed, taken


def test_the_loop_only_ever_holds_whole_records_while_a_writer_works_flat_out() -> None:
    count, box = 300_000, mailbox(record_dtype(Command))
    record, scratch, held = (np.zeros(len(box) - 1, np.int64) for _ in range(3))
    writer = threading.Thread(target=post_many, args=(box, record, count))
    writer.start()
    mixed, taken = receive_until(box, count, scratch, held)
    writer.join()
    assert mixed == 0
    assert 0 < taken <= count


def test_an_old_record_and_one_being_written_are_left_alone() -> None:
    box = mailbox(record_dtype(Command))
    command, held = np.zeros(1, record_dtype(Command)), np.zeros(1, record_dtype(Command))
    scratch = np.zeros(len(words(held)), np.int64)
    assert receive(box, 0, scratch, words(held)) == 0
    command["n"] = 7
    post(box, words(command))
    seen = receive(box, 0, scratch, words(held))
    assert held["n"] == 7
    box[0] += 1
    box[1] = 99
    assert receive(box, seen, scratch, words(held)) == seen
    assert held["n"] == 7
