let told = -Infinity;
for (const name of ["pointerdown", "pointermove", "wheel", "keydown"])
  addEventListener(name, ({ timeStamp }) => {
    if (timeStamp - told < 1000) return;
    told = timeStamp;
    parent.postMessage({ tendril: "touched" }, location.origin);
  }, { capture: true, passive: true });
