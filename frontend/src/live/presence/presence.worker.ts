/** Signs of presence from a thread of its own: a busy main thread does not hold them up, a hidden tab does not throttle
 * them, and they end with the page. */
import { socketUrl } from "../../api/socket";
import { SIGN_PERIOD_MS, PresenceSigns, type PageName } from "./presence";

const signs = new PresenceSigns({
  now: () => performance.now(),
  ask: () => postMessage(null),
  open: (page, heard, closed) => {
    const socket = new WebSocket(socketUrl(location, `/ws/presence/${page}`));
    socket.onopen = socket.onmessage = heard;
    socket.onclose = closed;
    return {
      get isOpen() {
        return socket.readyState === WebSocket.OPEN;
      },
      send: (text) => socket.send(text),
      close: () => socket.close(),
    };
  },
});

onmessage = ({ data }: MessageEvent<PageName>) => {
  signs.answered(data);
};
setInterval(() => signs.tick(), SIGN_PERIOD_MS);
