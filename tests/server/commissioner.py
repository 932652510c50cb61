"""An operator who commissions a virtual rig from its page, and sees with their own eyes which chamber fills."""

import time
from typing import Any

import httpx
import numpy as np

from controller.schema.rig_file import RigFile, read_rig_file
from server.campaign.waiting import wait
from server.hardware.commissioning.messages import CHAMBERS, Chamber
from tests.server.virtual_stack import Stack

READY, STEP = 60.0, 300.0
"""Longest waits for a rig that starts again, and for the end of a step [s]."""
EMPTY = 2e3
"""A chamber below this is empty [Pa]."""
TRIES, PAUSED = 5, "pressures lost"
"""A shared machine pauses: a board then seems to lose frames, and what moves is stopped."""


class Commissioner:
    """Everything by the API, as the page does it."""

    def __init__(self, stack: Stack, true: RigFile) -> None:
        """`true`: the rig as it really is, which the rig's own file may not know."""
        assert stack.virtual is not None
        self.stack, self.true, self.virtual = stack, true, stack.virtual
        self.began = time.monotonic()
        wait(lambda: all(one["state"] == "running" for one in stack.drivers().values()), READY, "devices that run", 0.1)

    def state(self) -> dict[str, Any]:
        found: dict[str, Any] = self.stack.person.ask("GET", "/api/commissioning")
        return found

    def step(self, name: str) -> dict[str, Any]:
        return next(one for one in self.state()["steps"] if one["name"] == name)

    def numbers(self, name: str) -> dict[str, dict[str, Any]]:
        return {one["name"]: one for one in self.step(name)["numbers"]}

    def rig(self) -> RigFile:
        """What the rig's own file says now."""
        return read_rig_file(self.virtual.path)

    def post(self, step: str, what: str, **body: Any) -> httpx.Response:
        return self.stack.person.request("POST", f"/api/commissioning/{step}/{what}", **body)

    def start(self, step: str, **body: Any) -> None:
        """Once the rig runs with what its file says."""
        last = [""]

        def begun() -> bool:
            answer = self.post(step, "start", **{"repeats": 1, **body})
            last[0] = answer.text
            return answer.is_success

        try:
            wait(begun, READY, f"the start of {step}", 0.3)
        except Exception as error:
            error.add_note(last[0])
            raise

    def ended(self, step: str) -> dict[str, Any]:
        wait(lambda: self.state()["running"] is None, STEP, f"the end of {step}", 0.1)
        found = self.step(step)
        print(f"{time.monotonic() - self.began:6.1f} s  {step}: {found['state']}, {found['result']}", flush=True)
        return found

    def go(self, step: str, **body: Any) -> None:
        """The step from start to acceptance; once more where the machine stood still, and the rig was stopped by it."""
        for _ in range(TRIES):
            self.start(step, **body)
            if PAUSED not in self.ended(step)["result"]:
                break
            self.stack.person.command("clear")
        self.accept(step)

    def run(self, task: str) -> dict[str, Any]:
        """What came of a run at the operator's own settings, likewise."""
        wait(lambda: not self.step("drivers")["needs"], READY, "a rig that runs with its file", 0.3)
        for _ in range(TRIES):
            self.stack.arm()
            found = self.stack.run(task)
            told = f"{found['state']} {found['reason']}, RMSE {found['rmse']} m"  # None of a run that is broken off
            print(f"{time.monotonic() - self.began:6.1f} s  {task}: {told}")
            if PAUSED not in found["reason"]:
                break
        return found

    def done(self, step: str) -> dict[str, Any]:
        """It ended well, and is accepted."""
        found = self.ended(step)
        assert found["state"] == "done", found["result"]
        self.accept(step)
        return found

    def accept(self, step: str) -> None:
        answer = self.post(step, "accept")
        assert answer.is_success, answer.text
        for one in self.step(step)["writes"]:
            print(f"          {one['field']}: {one['before']} -> {one['after']}", flush=True)

    def back(self, step: str) -> None:
        """As soon as the rig has begun again, where the step before has made it do so."""
        wait(lambda: self.post(step, "back").is_success, READY, f"the way back to {step}", 0.3)

    def drivers(self) -> None:
        for _ in range(TRIES):
            self.start("drivers")
            if self.ended("drivers")["state"] == "done":
                break
        self.accept("drivers")

    def jog(self, mistaken: dict[Chamber, Chamber] | None = None) -> None:
        """Fill each chamber and say which one filled, but where that is `mistaken` for another."""
        self.start("jog")
        wait(
            lambda: "waits for" in (self.state()["running"] or {"doing": ""})["doing"], READY, "a button to press", 0.1
        )
        for chamber in CHAMBERS:
            self._hold(chamber)
            seen = self._filled()
            self.stack.person._http.put("/api/commissioning/jog", json={"chamber": None}).raise_for_status()
            wait(lambda: max(self._pressures()) < EMPTY, READY, "an empty chamber", 0.1)
            said = (mistaken or {}).get(seen, seen)
            self.stack.person.ask("PUT", "/api/commissioning/jog/confirm", commanded=chamber, filled=said)

    def frame(self) -> None:
        """All three captures."""
        self.at_rest()
        self._capture("bent", "tip")

    def at_rest(self) -> None:
        """Touch the base with a wand, then capture the tip."""
        self.start("frame")
        self.virtual.do("wand 0 0")
        self._capture("base", "wand", "wand")
        self.virtual.do("wand off")
        self._capture("tip", "tip")

    def _capture(self, place: str, point: str, *more: str) -> None:
        names = {*self.true.motion_capture.labels, *more}
        wait(lambda: names == {*self.stack.drivers()["motion_capture"]["values"]}, READY, f"{names} to be seen", 0.05)
        self.stack.person.ask("PUT", "/api/commissioning/frame/capture", place=place, point=point)

    def _hold(self, chamber: Chamber) -> None:
        """A button, until the page shows that this chamber was jogged."""
        end = time.monotonic() + READY
        while not any(one["commanded"] == chamber for one in self.state()["jog"]["jogged"]):
            assert time.monotonic() < end, f"{chamber} was never jogged"
            self.stack.person.ask("PUT", "/api/commissioning/jog", chamber=chamber)
            time.sleep(0.1)

    def _pressures(self) -> list[float]:
        found: list[float] = self.stack.drivers()["valves"]["values"]["pressures"]
        return found

    def _filled(self) -> Chamber:
        """The chamber that is full: what hangs at the fullest channel."""
        channel = self.rig().valves.chambers[int(np.argmax(self._pressures()))]
        return CHAMBERS[self.true.valves.chambers.index(channel)]
