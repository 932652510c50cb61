"""One period of the controller, stage by stage, as in the paper's block diagram."""

from numba import njit

from controller.kernels.feedback import feed_back, saturate
from controller.kernels.feedforward import feed_forward
from controller.kernels.follow import refer
from controller.kernels.memory import Rig as Rig
from controller.kernels.observer import observe, sense
from controller.kernels.report import report_command, report_estimate, report_loop
from controller.kernels.safety import supervise
from controller.kernels.timing import begin, feedforward_due


@njit(cache=True, nogil=True, error_model="numpy")
def tick(rig, t_ns, command, measurement, status, telemetry):
    """Advance the rig by one period and fill the `telemetry` row, but for `slot` and `twin_backbone`.

    `t_ns` is the clock at the start of the tick; the others are records (controller/messages.py). Nothing allocates,
    nothing raises, and the same inputs give the same row bit for bit.
    """
    periods = begin(rig, t_ns)
    sense(rig, t_ns, command.settings, measurement)
    observe(rig, command.settings, periods)
    report_estimate(rig, t_ns, measurement, telemetry)
    supervise(rig, t_ns, command, status, measurement)
    due = feedforward_due(rig, command.settings)
    refer(rig, command, due)
    feed_forward(rig, command.settings, due)
    feed_back(rig, command.settings, telemetry)
    saturate(rig, command.settings, telemetry)
    report_command(rig, command, telemetry)
    report_loop(rig, t_ns, command, status, telemetry)
