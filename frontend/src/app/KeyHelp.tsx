import { Kbd, Modal } from "@mantine/core";
import { PageStore, usePage } from "../live/page";
import { KEY_LIST } from "../operate/target/keys";
import { useService } from "../ui/services";

/** The list of keys; the page stays in sight, as the rig goes on. */
export function KeyHelp() {
  const page = useService(PageStore);
  const opened = usePage((state) => state.help);
  return (
    <Modal
      opened={opened}
      onClose={() => {
        page.patch({ help: false });
      }}
      title="Keys"
      size="md"
      centered
      withOverlay={false}
      lockScroll={false}
      closeButtonProps={{ "aria-label": "Close the list of keys" }}
    >
      <dl className="keys" data-testid="keys">
        {KEY_LIST.map(([key, meaning]) => (
          <div key={key}>
            <dt>
              {key.split(" ").map((part, i) => (
                <Kbd key={i}>{part}</Kbd>
              ))}
            </dt>
            <dd>{meaning}</dd>
          </div>
        ))}
      </dl>
      <p className="note">
        In the plan: drag the target; drag empty space to pan; wheel or pinch to zoom; double-click to fit.
      </p>
    </Modal>
  );
}
