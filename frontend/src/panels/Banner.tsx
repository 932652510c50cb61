import { IconPlugConnectedX } from "@tabler/icons-react";
import { seconds } from "../state/format";
import { LiveText } from "./LiveText";
import { useDashboard, usePage } from "./context";

/** Over the last picture, when it is old: what is missing, and since when. */
export function Banner() {
  const { live } = useDashboard();
  const online = usePage((page) => page.online);
  const rigLive = usePage((page) => page.rigLive);
  if (online && rigLive) return null;
  return (
    <div className="banner" role="alert" data-testid="banner">
      <IconPlugConnectedX size={18} aria-hidden />
      <span>
        {online ? "The rig does not answer" : "No connection to the server; trying again"}
        {live.frames > 0 ? (
          <>
            {" · last picture "}
            <LiveText read={() => seconds((performance.now() - live.freshAt) / 1e3)} rate={2} />
            {" old"}
          </>
        ) : null}
      </span>
    </div>
  );
}
