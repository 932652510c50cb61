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
