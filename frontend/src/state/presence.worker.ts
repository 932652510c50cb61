/** A timer that a hidden tab does not throttle. The page itself sends presence, so a hung page is not present. */
const PERIOD_MS = 50;

setInterval(() => {
  postMessage(null);
}, PERIOD_MS);
