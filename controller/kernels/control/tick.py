"""One period of the controller, stage by stage, as in the paper's block diagram."""

from controller.arrays import Record
from controller.kernels.compiled import kernel
from controller.kernels.control.begin import begin
from controller.kernels.control.feedback import feed_back, saturate
from controller.kernels.control.feedforward import feed_forward
from controller.kernels.control.follow import refer
from controller.kernels.control.report import report_command, report_estimate, report_loop
from controller.kernels.control.timing import begin_tick, feedforward_due
from controller.kernels.group import Group
from controller.kernels.memory import Control, Sensing
from controller.kernels.observer.observer import Observer, observe
from controller.kernels.observer.reseat import reseat
from controller.kernels.observer.sensing import sense
from controller.kernels.safety.oscillation import note_residual
from controller.kernels.safety.safety import supervise


class Rig(Group):
    """Everything one tick needs beside its messages; built once by `build_rig`."""

    control: Control
    observer: Observer
    sensing: Sensing


@kernel
def tick(t_ns: int, command: Record, measurement: Record, status: Record, rig: Rig, out_telemetry: Record) -> None:
    """Advance the rig by one period and fill the row `out_telemetry`, but for `slot` and `twin_backbone`.

    Paper, "Controller Architecture", the block diagram. `t_ns` is the clock at the start of the tick; the others are
    records (controller/schema/messages.py). Nothing allocates, nothing raises, and the same inputs give the same row
    bit for bit. In place: rig.
    """
    control, observer, sensing = rig.control, rig.observer, rig.sensing
    settings = command.settings
    periods = begin_tick(t_ns, control)
    sense(observer, t_ns, settings, measurement, control, sensing)
    observe(t_ns, settings, measurement, periods, sensing, control, observer)
    report_estimate(control, sensing, t_ns, measurement, observer, out_telemetry)
    note_residual(out_telemetry.residual, control)
    reseat(sensing, control, observer, out_telemetry)
    supervise(t_ns, command, status, measurement, observer.u_hat, control)
    begin(settings, out_telemetry, sensing, control)
    due = feedforward_due(control, settings)
    refer(command, due, control)
    feed_forward(settings, due, control)
    feed_back(settings, control, out_telemetry)
    saturate(control, out_telemetry)
    report_command(control, command, out_telemetry)
    report_loop(t_ns, command, status, control, out_telemetry)
