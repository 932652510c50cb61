"""Foreign pages inside ours (viser, rerun): same origin, but a process of their own.

They share cookies with our page, so they must be of our origin; they also draw heavily, and in the same process a slow
graphics driver would stop our page with them, its plan view, its E-STOP and the operator's presence included. The
Document-Isolation-Policy header parts the two where the browser knows it (Chromium); elsewhere nothing changes.
"""

from pathlib import Path

ISOLATION = {"document-isolation-policy": "isolate-and-require-corp"}
"""Headers of such a page."""
SCRIPTS = Path(__file__).with_name("frame_scripts")


def _script(name: str) -> bytes:
    """The script of this name, to be put into such a page."""
    return b"<script>\n" + (SCRIPTS / f"{name}.js").read_bytes() + b"</script>"


TELL_ESCAPE = _script("tell_escape")
"""Put into such a page: Esc means HOLD wherever the focus is, and our page cannot listen inside another process."""

TELL_TOUCHED = _script("tell_touched")
"""Put into such a page: whose hand is in it touches our page, which else locks itself (frontend/src/operate/lock)."""

TELL_MOVED = _script("tell_moved")
"""Put into viser's page: where the frame changes under a press, its drags end, and our page holds the rig.

As on our plan (frontend/src/plan/pointer/ground.ts), a pointer that goes further in the frame than on the screen was
carried.
"""

DRAW_SPARINGLY = _script("draw_sparingly")
"""Put into viser's page: where there is no graphics processor, it draws ten pictures a second while our page says so.

Viser draws 60 a second as long as anything moves. In software that is half of a core in the very process that also
puts our page on the screen, and the operator's hand would see its answer 30 to 150 ms later.
"""

SEND_COOKIE = _script("send_cookie")
"""Put into rerun's page: its viewer asks for recordings without credentials, and would be refused."""
