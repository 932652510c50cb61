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
      onClose={() => page.patch({ help: false })}
      title="Keys"
      size="md"
      centered
      withOverlay={false}
      lockScroll={false}
      closeButtonProps={{ "aria-label": "Close the list of keys" }}
    >
      <div className="keys" data-testid="keys">
        {KEY_LIST.map(({ where, keys }) => (
          <section key={where} aria-label={where}>
            <h3>{where}</h3>
            <dl>
              {keys.map(([key, meaning]) => (
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
          </section>
        ))}
      </div>
    </Modal>
  );
}
