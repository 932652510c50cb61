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
