"""Leaves the running product as the next module of tests expects it, whatever the one before did to it."""

import time
from typing import Any

import httpx

from controller.schema.modes import Mode
from tests.e2e.product import PATIENCE_S, Product, wait_until

WAY_OUT = {Mode.HOLD: "rest", Mode.FOLLOW: "rest", Mode.TRACK: "rest", Mode.FAULT: "clear", Mode.E_STOP: "clear"}


class Caretaker:
    """Signed in by the token, it operates once no one else does any more."""

    def __init__(self, product: Product) -> None:
        self._product = product
        self._client = httpx.Client(base_url=product.origin, timeout=PATIENCE_S, trust_env=False)
        self._sign_in()
        wait_until(lambda: self._client.get("/api/rig").is_success)
        self._settings = self._read("/api/settings")
        self._actuator, self._plant = self._built()

    def _built(self) -> tuple[str, str]:
        """Name of the actuator, and the plant that simulates it."""
        parameters = self._read("/api/rig")["parameters"]
        return parameters["actuator"]["name"], parameters["twin"]["plant"]

    def close(self) -> None:
        """Sign off."""
        self._client.close()

    def put_to_rest(self) -> None:
        """Vented, nothing recorded, injected, drawn or changed, and no one operates."""
        self._sign_in()  # a module may have signed out all who came with the token
        wait_until(lambda: self._client.post("/api/lease").is_success, each=lambda: time.sleep(0.5))
        self._client.delete("/api/recordings/current")  # 409 where nothing is recorded
        wait_until(self._vented)
        self._operate("PATCH", "/api/lease", clutch=False)
        self._operate("PUT", "/api/twin/faults")
        if self._built()[0] != self._actuator:
            self._operate("PUT", "/api/rig/actuator", name=self._actuator)
            wait_until(lambda: self._built()[0] == self._actuator)
        if self._built()[1] != self._plant:
            self._operate("PUT", "/api/rig/plant", plant=self._plant)
            wait_until(lambda: self._built()[1] == self._plant)
        for drawing in self._read("/api/drawings"):
            self._operate("DELETE", f"/api/drawings/{drawing['name']}")
        now = self._read("/api/settings")
        if changes := {name: value for name, value in self._settings.items() if now[name] != value}:
            self._operate("PATCH", "/api/settings", changes=changes)
        self._operate("DELETE", "/api/lease")

    def _sign_in(self) -> None:
        token = self._product.url.split("token=")[1]
        self._client.post("/api/session", json={"token": token}).raise_for_status()

    def _vented(self) -> bool:
        mode = self._product.mode()
        if mode in WAY_OUT:
            self._client.post("/api/command", json={"request": WAY_OUT[mode]})
        return mode == Mode.VENTED

    def _operate(self, method: str, path: str, **body: Any) -> None:
        """As the operator: the lease lapses between two requests that take long."""
        self._client.post("/api/lease").raise_for_status()
        content = None if method == "DELETE" else body
        self._client.request(method, path, json=content).raise_for_status()

    def _read(self, path: str) -> Any:
        return self._client.get(path).raise_for_status().json()
