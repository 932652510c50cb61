"""Programs that we did not write take our emulator for Motive: the client natnet, and libmotioncapture's OptiTrack."""

import time

import numpy as np
import pytest

from controller.drivers.device import DeviceError
from controller.virtual.natnet_server import NatNetServer
from tests.controller.drivers.conftest import LABELS, frames, named, showing

pytestmark = pytest.mark.keyed()

natnet = pytest.importorskip("natnet")
vendor = pytest.importorskip("controller.drivers.capture.vendor")

GROUP = "239.255.42.99"
EACH = pytest.mark.parametrize(
    ("version", "group"), [(version, group) for version in ("3.0", "3.1", "4.0", "4.1") for group in ("", GROUP)]
)


@EACH
def test_the_public_client_natnet_sees_the_points_and_names(version, group, capsys):
    server = NatNetServer(version, ("tip", "hidden", "mid"), group)
    client = natnet.NatNetClient(
        server.address,
        server.address,
        multicast_address=group or GROUP,
        command_port=0,
        use_multicast=bool(group),
    )
    got, defined = [], []
    client.on_data_frame_received_event.handlers.append(got.append)
    client.on_data_description_received_event.handlers.append(defined.append)
    with showing(server):
        client._NatNetClient__command_port, client._NatNetClient__data_port = server.command_port, server.data_port
        client.connect(2.0)
        client.request_modeldef()
        client.run_async()
        end = time.monotonic() + 2.0
        while not (len(got) > 5 and defined) and time.monotonic() < end:
            time.sleep(0.01)
        client.shutdown()
    assert str(client.protocol_version).startswith(version)
    frame = got[-1]
    names = {body.id_num: body.name for body in defined[0].rigid_bodies}
    bodies = {names[body.id_num]: body for body in frame.rigid_bodies}
    assert bodies["tip"].pos == pytest.approx((0.1, 0.2, 0.3)) and bodies["tip"].tracking_valid
    assert not bodies["hidden"].tracking_valid
    assert frame.unlabeled_marker_pos[0] == pytest.approx((0.4, 0.5, 0.6))
    assert [marker.occluded for marker in frame.labeled_markers] == [False, True, False, False]
    assert frame.suffix.stamp_camera_mid_exposure > 0
    assert capsys.readouterr().out == ""  # it prints where a packet's size or order is not what it knows


@pytest.mark.process
@EACH
def test_libmotioncaptures_optitrack_sees_the_bodies(opened, version, group):
    server = NatNetServer(version, ("tip", "hidden", "mid"), group, to_data_port=True)
    with showing(server):
        settings = [f"interface_ip={server.address}", f"port_command={server.command_port}"]
        device = opened(
            vendor.Vendor(vendor.VendorOptions(system="optitrack", hostname=server.address, settings=settings))
        )
        sample, read = frames(device, 3)[-1]
    assert named(sample) == {"tip": [0.1, 0.2, 0.3], "mid": [0.7, 0.8, 0.9]}
    assert 0 <= read - sample.t_ns < 1_000_000_000


@pytest.mark.process
def test_libmotioncaptures_first_frame_comes_as_soon_as_it_is_connected(opened):
    server = NatNetServer("4.1", ("tip",), GROUP)
    settings = [f"interface_ip={server.address}", f"port_command={server.options['command_port']}"]
    options = vendor.VendorOptions(system="optitrack", hostname=server.address, settings=settings)
    with showing(server):
        first = [frames(opened(vendor.Vendor(options)), 1)[0] for _ in range(3)]
    assert min(read - sample.t_ns for sample, read in first) < 50_000_000  # of three, for the machine itself may pause


def test_the_wheel_says_what_it_has_and_a_system_that_it_has_not_is_refused():
    there = vendor.systems()
    assert {"vicon", "qualisys", "vrpn", "optitrack"} <= set(there)
    assert "nokov" not in there
    with pytest.raises(DeviceError, match=r"system = nokov: this wheel of motioncapture has .*vicon"):
        vendor.Vendor(vendor.VendorOptions(system="nokov")).open()


@pytest.mark.process
def test_a_system_that_does_not_answer_is_an_error_and_leaves_no_process(opened, monkeypatch):
    monkeypatch.setattr(vendor, "OPENING", 0.5)
    device = vendor.Vendor(vendor.VendorOptions(system="optitrack", hostname="127.0.0.1", settings=["port_command=9"]))
    with pytest.raises(DeviceError, match=r"no connection within 0\.5 s"):
        device.open()
    assert device._process is None
    monkeypatch.undo()  # a busy machine takes longer than that to start the process that says the next
    with pytest.raises(DeviceError, match="Error connecting QTM"):
        vendor.Vendor(vendor.VendorOptions(system="qualisys", hostname="127.0.0.1", settings=["port=9"])).open()


@pytest.mark.process
def test_vrpn_without_a_server_gives_nothing_though_its_back_end_gives_frames(opened, monkeypatch):
    monkeypatch.setattr(vendor, "SILENCE", 0.3)
    device = opened(vendor.Vendor(vendor.VendorOptions(system="vrpn", hostname="127.0.0.1:9")))
    with pytest.raises(DeviceError, match=r"nothing new came from vrpn at 127\.0\.0\.1:9 for 0\.3 s"):
        for _ in range(100):
            assert device.read(0.1) is None


@pytest.mark.process
def test_a_process_that_is_killed_is_a_lost_device(opened):
    device = opened(vendor.Vendor(vendor.VendorOptions(system="mock", settings=["rigid_bodies=tip(1,2,3,1,0,0,0)"])))
    assert np.allclose(frames(device, 1)[0][0].points, [[1.0, 2.0, 3.0]])
    device._process.kill()
    with pytest.raises(DeviceError, match="the connection ended"):
        for _ in range(1000):
            device.read(0.1)
    device.open()
    assert frames(device, 1)[0][0].labels == LABELS[:1]
