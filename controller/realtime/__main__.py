"""`python -m controller.realtime SETTINGS`: run one rig; SETTINGS is a `RigSettings` as JSON."""

import logging
import sys

from controller.realtime.priority import prefer_process


def main() -> None:
    """The heavy imports come after the priority: on a busy machine they are most of a restart."""
    prefer_process()
    from controller.errors import TendrilError
    from controller.realtime.rig import RigSettings, run_rig
    from controller.realtime.settings import REFUSED
    from controller.system.logs import log_json

    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    settings = RigSettings.model_validate_json(sys.argv[1])
    if settings.log_format == "json":
        log_json("rig")
    try:
        run_rig(settings)
    except TendrilError as error:
        logging.getLogger("controller.realtime").critical("%s", error)
        sys.exit(REFUSED)


main()
