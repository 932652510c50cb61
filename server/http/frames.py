"""Foreign pages inside ours (viser, rerun): same origin, but a process of their own.

They share cookies with our page, so they must be of our origin; they also draw heavily, and in the same process a slow
graphics driver would stop our page with them, its plan view, its E-STOP and the operator's presence included. The
Document-Isolation-Policy header parts the two where the browser knows it (Chromium); elsewhere nothing changes.
"""

ISOLATION = {"document-isolation-policy": "isolate-and-require-corp"}
"""Headers of such a page."""

TELL_ESCAPE = b"""<script>
addEventListener("keydown", (event) => {
  if (event.key === "Escape" && !event.repeat) parent.postMessage({ tendril: "escape" }, location.origin);
}, { capture: true });
</script>"""
"""Put into such a page: Esc means HOLD wherever the focus is, and our page cannot listen inside another process."""

TELL_TOUCHED = b"""<script>
let told = -Infinity;
for (const name of ["pointerdown", "pointermove", "wheel", "keydown"])
  addEventListener(name, ({ timeStamp }) => {
    if (timeStamp - told < 1000) return;
    told = timeStamp;
    parent.postMessage({ tendril: "touched" }, location.origin);
  }, { capture: true, passive: true });
</script>"""
"""Put into such a page: whose hand is in it touches our page, which else locks itself (frontend/src/operate/lock)."""

TELL_MOVED = b"""<script>
let pressed = null, dead = false;
const end = () => {
  if (!pressed || dead) return;
  dead = true;
  parent.postMessage({ tendril: "moved" }, location.origin);
};
addEventListener("resize", end);
addEventListener("pointerdown", (event) => { [pressed, dead] = [event, false]; }, { capture: true });
addEventListener("pointermove", (event) => {
  if (!pressed || event.pointerId !== pressed.pointerId) return;
  const way = Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY);
  const hand = Math.hypot(event.screenX - pressed.screenX, event.screenY - pressed.screenY);
  if (way > 4 * hand + 2) end();
  pressed = event;
  if (dead) event.stopImmediatePropagation();
}, { capture: true });
for (const name of ["pointerup", "pointercancel"])
  addEventListener(name, () => { pressed = null; }, { capture: true });
</script>"""
"""Put into viser's page: where the frame changes under a press, its drags end, and our page holds the rig.

As on our plan (frontend/src/plan/pointer/ground.ts), a pointer that goes further in the frame than on the screen was
carried.
"""

DRAW_SPARINGLY = b"""<script>
{
  const [next, drop] = [requestAnimationFrame.bind(window), cancelAnimationFrame.bind(window)];
  const late = new Map();
  let [sparing, software, drawn, ids] = [false, null, 0, 0];
  const isSoftware = () => {
    const gl = document.createElement("canvas").getContext("webgl");
    const named = gl?.getExtension("WEBGL_debug_renderer_info");
    const name = String(gl?.getParameter(named ? named.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
    gl?.getExtension("WEBGL_lose_context")?.loseContext();
    return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
  };
  addEventListener("message", ({ origin, data }) => {
    if (origin !== location.origin || data?.tendril !== "sparing") return;
    software ??= isSoftware();
    sparing = software && data.on === true;
  });
  requestAnimationFrame = (draw) => {
    const wait = sparing ? drawn + 100 - performance.now() : 0;
    const run = (now) => { drawn = now; draw(now); };
    if (wait <= 0) return next(run);
    const id = --ids;
    const timer = setTimeout(() => {
      const frame = next((now) => { late.delete(id); run(now); });
      late.set(id, () => drop(frame));
    }, wait);
    late.set(id, () => clearTimeout(timer));
    return id;
  };
  cancelAnimationFrame = (id) => {
    const stop = late.get(id);
    late.delete(id);
    if (stop) stop(); else drop(id);
  };
}
</script>"""
"""Put into viser's page: where there is no graphics processor, it draws ten pictures a second while our page says so.

Viser draws 60 a second as long as anything moves. In software that is half of a core in the very process that also
puts our page on the screen, and the operator's hand would see its answer 30 to 150 ms later.
"""

SEND_COOKIE = b"""<script>
const plainFetch = fetch;
fetch = (request, options) =>
  new URL(request.url ?? request, location).origin === location.origin
    ? plainFetch(request, { ...options, credentials: "same-origin" })
    : plainFetch(request, options);
</script>"""
"""Put into rerun's page: its viewer asks for recordings without credentials, and would be refused."""
