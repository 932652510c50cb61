"""The LSL driver against real outlets of pylsl on this machine; in a process of its own, for LSL is configured once."""

import os
import subprocess
import sys
from importlib.util import find_spec

import pytest

pytestmark = pytest.mark.process

CONFIGURATION = """
[ports]
IPv6 = disable
[multicast]
ResolveScope = machine
[log]
level = -3
"""

SCRIPT = """
import time
import numpy as np
import pylsl
import pytest
from controller.drivers.device import DeviceError
from controller.drivers.capture.lsl import LslCapture, LslOptions

def outlet(name, channels=6, form="float32", labels=("tip", "mid")):
    info = pylsl.StreamInfo(name, "MoCap", channels, 100, form, f"tendril-{name}")
    described = info.desc().append_child("channels")
    for label in labels:
        for axis in "XYZ":
            described.append_child("channel").append_child_value("label", f"{label}_{axis}")
    return pylsl.StreamOutlet(info, chunk_size=1)

def refused(text, **options):
    with pytest.raises(DeviceError, match=text):
        LslCapture(LslOptions(**options)).open()

name = f"rods-{time.monotonic_ns()}"
out = outlet(name)
device = LslCapture(LslOptions(stream=name, scale=0.001))
device.open()
errors = []
for k in range(60):
    captured = time.monotonic_ns() - 7_000_000
    out.push_sample([100.0, 200.0, 300.0, 400.0, 500.0, float("nan")], captured * 1e-9)
    sample = device.read(1.0)
    errors.append((sample.t_ns - captured) * 1e-6)
    time.sleep(0.002)
assert sample.labels == ("tip", "mid"), sample.labels
assert np.allclose(sample.points, [[0.1, 0.2, 0.3], [0.4, 0.5, np.nan]], equal_nan=True)
assert device.clock == "two-way" and abs(np.median(errors)) < 5.0, np.median(errors)
print(f"time of capture wrong by {np.median(errors):.3f} ms")

for hostile in ([float("inf")] * 6, [1e30] * 6):
    out.push_sample(hostile, time.monotonic())
    assert device.read(1.0) is None
out.push_sample([0.0] * 6, 1e-3)
assert device.read(1.0) is None and device.rejected == 3

flat = LslCapture(LslOptions(stream=name, dimensions=2, labels=("a", "b", "c")))
flat.open()
out.push_sample([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
sample = flat.read(1.0)
assert sample.labels == ("a", "b", "c") and sample.points.shape == (3, 2)
flat.close()
refused("labels name 1 points, LSL stream .* has 2", stream=name, labels=("a",))

del out
with pytest.raises(DeviceError, match="lost"):
    end = time.monotonic() + 10.0
    while time.monotonic() < end:
        device.read(0.1)
refused("no LSL stream of name", stream=name)
out = outlet(name)
device.open()
out.push_sample([1.0] * 6)
assert device.read(1.0) is not None
device.close()
device.close()
"""


@pytest.mark.skipif(find_spec("pylsl") is None, reason="pylsl is not installed")
def test_a_stream_is_found_read_with_its_own_times_and_labels_lost_and_found_again(tmp_path, capsys):
    (tmp_path / "lsl.cfg").write_text(CONFIGURATION)
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        env=os.environ | {"LSLAPICFG": str(tmp_path / "lsl.cfg")},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    with capsys.disabled():
        print("\n" + done.stdout.strip())
