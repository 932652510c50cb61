addEventListener("keydown", (event) => {
  if (event.key === "Escape" && !event.repeat) parent.postMessage({ tendril: "escape" }, location.origin);
}, { capture: true });
