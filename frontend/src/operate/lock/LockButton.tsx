import { Button, NativeSelect } from "@mantine/core";
import { IconLock, IconLockOpen } from "@tabler/icons-react";
import { useSyncExternalStore } from "react";
import { HeaderPopover } from "../../ui/buttons/HeaderPopover";
import { useService } from "../../ui/services";
import { useStore } from "../../ui/store";
import { TIMES, TouchLock, WAYS, type Way } from "./lock";

/** A screen that is touched, by whatever else it is used as well. */
const touched = window.matchMedia("(any-pointer: coarse)");

/** Whether this screen is one that is touched. */
export const isTouchScreen = () => touched.matches;

const WAY: Record<Way, string> = { slide: "Slide", hold: "Hold for 1 s", number: "Type a number" };
const TIME = (after: number) =>
  after === 0 ? "Off" : after < 60 ? `${after} s without a touch` : `${after / 60} min without a touch`;

/** Where the page is locked, and what locks and unlocks it is chosen; only where it is touched. */
export function LockButton() {
  const lock = useService(TouchLock);
  const shown = useSyncExternalStore(subscribe, isTouchScreen);
  const { after, by } = useStore(lock.choice, (choice) => choice);
  if (!shown) return null;
  return (
    <HeaderPopover
      title="Touch lock"
      state={after === 0 ? "off" : TIME(after)}
      icon={after === 0 ? <IconLockOpen size={18} /> : <IconLock size={18} />}
      testId="lock-menu"
    >
      {(close) => (
        <>
          <NativeSelect
            label="Lock after"
            value={after}
            data={TIMES.map((time) => ({ value: String(time), label: TIME(time) }))}
            data-testid="lock-after"
            onChange={(event) => lock.choose({ after: Number(event.currentTarget.value) })}
          />
          <NativeSelect
            label="Unlock by"
            value={by}
            data={WAYS.map((way) => ({ value: way, label: WAY[way] }))}
            data-testid="lock-by"
            onChange={(event) =>
              lock.choose({ by: WAYS.find((way) => way === event.currentTarget.value) ?? by })
            }
          />
          <p className="note">
            While it is locked only E-STOP and Hold act; what moves goes on. Kept by this browser.
          </p>
          <Button
            size="xs"
            variant="default"
            w="fit-content"
            data-testid="lock-now"
            onClick={() => {
              close();
              lock.lock();
            }}
          >
            Lock now
          </Button>
        </>
      )}
    </HeaderPopover>
  );
}

function subscribe(listener: () => void): () => void {
  touched.addEventListener("change", listener);
  return () => {
    touched.removeEventListener("change", listener);
  };
}
