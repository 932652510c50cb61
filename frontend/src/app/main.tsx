import "@mantine/core/styles.css";
import "@mantine/notifications/styles.css";
import "uplot/dist/uPlot.min.css";
import "@fontsource-variable/inter/wght.css";
import "./index.css";
import { createTheme, MantineProvider, Menu, Modal, Popover } from "@mantine/core";
import { Notifications, notifications } from "@mantine/notifications";
import { createRoot } from "react-dom/client";
import { Connection } from "../live/connection";
import { PageStore } from "../live/page";
import { TouchLock } from "../operate/lock/lock";
import { LockCover } from "../operate/lock/LockCover";
import type { Notify } from "../operate/operations";
import { StopBar } from "../operate/stop/StopBar";
import { Gamepads } from "../operate/target/gamepads";
import { followAddress } from "../recorder/place";
import { FONT, publishColours } from "../ui/colours";
import { FocusKeeper } from "../ui/focus";
import { markLayout } from "../ui/narrow";
import { ServicesContext } from "../ui/services";
import { App } from "./App";
import { hearKeys } from "./keys";
import { hearPastes } from "./pasteNumber";
import { wire } from "./wiring";

const COLOUR = { info: "blue", warning: "yellow", error: "red" } as const;

/** What opens beside a control leaves the upper edge to state and E-STOP [px]. */
const BESIDE_STOP = { top: 60, right: 5, bottom: 5, left: 5 };

/** What opens and closes does so at once: what is still to be seen is still open (operate/stop/escape.ts). */
const AT_ONCE = { duration: 0 };

const notify: Notify = (level, title, text) =>
  notifications.show({
    id: `${title} ${text}`,
    color: COLOUR[level],
    title,
    message: text,
    autoClose: level === "error" ? 12_000 : 5000,
  });

const theme = createTheme({
  fontFamily: FONT,
  fontSizes: { xs: "12px", sm: "13px", md: "13px", lg: "16px", xl: "22px" },
  headings: { fontFamily: FONT, fontWeight: "600" },
  defaultRadius: "md",
  cursorType: "pointer",
  primaryShade: 8,
  components: {
    // Its placeholder for the focus is no child that a menu may have.
    Menu: Menu.extend({ defaultProps: { withInitialFocusPlaceholder: false } }),
    Modal: Modal.extend({ defaultProps: { transitionProps: AT_ONCE } }),
    Popover: Popover.extend({
      defaultProps: {
        middlewares: { flip: { padding: BESIDE_STOP }, shift: true },
        transitionProps: AT_ONCE,
      },
    }),
  },
});

const services = wire(notify, localStorage);
followAddress(services.get(PageStore));
void services.get(Connection).start();
services.get(Gamepads).start();
services.get(TouchLock).start();
hearKeys(services);
hearPastes(document, (text) => {
  notify("warning", "Not pasted", text);
});

markLayout();
publishColours(document.documentElement);

// A root of its own, and first: nothing that fails or is laid over the page takes the E-STOP with it.
const edge = document.getElementById("edge");
if (edge)
  createRoot(edge).render(
    <ServicesContext value={services}>
      <StopBar />
    </ServicesContext>,
  );

const lock = document.getElementById("lock");
if (lock)
  createRoot(lock).render(
    <ServicesContext value={services}>
      <LockCover />
    </ServicesContext>,
  );

const root = document.getElementById("root");
if (root) {
  new FocusKeeper(root).start();
  createRoot(root).render(
    <MantineProvider theme={theme} defaultColorScheme="auto">
      <Notifications position="bottom-right" limit={4} className="notices" />
      <ServicesContext value={services}>
        <App />
      </ServicesContext>
    </MantineProvider>,
  );
}
