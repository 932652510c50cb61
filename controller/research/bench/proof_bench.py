"""What it costs to prove telemetry and to judge it: one batch as the rig's pump sends it, 60 times a second."""

from typing import TypedDict

import numpy as np

from controller.link.keys import Keys
from controller.link.proof import Prover, read_batch
from controller.link.stream import Pace
from controller.research.bench.stopwatch import time_steps
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.system.keys import KEY_BYTES

ROWS = 10
COUNT = 50


class ProofFigures(TypedDict):
    """Medians for one batch of 10 rows [us]."""

    bytes: int
    prove_us: float
    """By the rig's pump."""
    judge_us: float
    """By the server: the proof, and whether the rows can follow."""


def time_proofs(rounds: int) -> ProofFigures:
    """Of a key and a batch made up; nothing is sent."""
    key, expression, boot = bytes(KEY_BYTES), Keys("rig").telemetry, 1
    rows = np.zeros(ROWS, record_dtype(Telemetry))
    rows["tick"] = rows["t_ns"] = np.arange(ROWS)
    payload, prover, pace = rows.tobytes(), Prover(key, boot), Pace(1e-3, 0, 0.0)
    proof = prover.batch(expression, payload)

    def prove(count: int) -> None:
        for _ in range(count):
            prover.batch(expression, payload)

    def judge(count: int) -> None:
        for _ in range(count):
            read_batch(key, expression, proof, payload)
            pace.judge(rows, 0.0)

    taken = [(time_steps(prove, COUNT), time_steps(judge, COUNT)) for _ in range(rounds)]
    made, judged = np.median(taken, axis=0)
    return ProofFigures(bytes=len(payload), prove_us=float(made), judge_us=float(judged))
