"""Deleted recordings, kept aside for a week so that they can be taken back.

A folder of the same form within the recordings' own. The place of a recording's description decides where it belongs:
one rename, after which a kill or a power cut only leaves data that follow at the next start.
"""

from pathlib import Path

from controller.errors import CommandRefused, RecordingError
from controller.system.whole_file import is_regular, sync_folder
from recordings.format import sidecar
from recordings.format.messages import Recording
from recordings.read import prepared
from recordings.store.age import read_ages, write_ages
from recordings.store.catalogue import Catalogue

FOLDER = ".deleted"
AGES = ".ages.json"
KEPT_S = 7 * 86_400.0
"""For so long, by the time that the machine ran, a deleted recording can be taken back [s]."""


class Bin:
    """The deleted recordings of `folder`. Who changes it has its turn (`sidecar.turn`), as with the recordings."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._bin = folder, folder / FOLDER
        self._catalogue = Catalogue(self._bin)

    def recordings(self) -> list[Recording]:
        """What was deleted and when, the last first."""
        found = [(self._since(one.id), one) for one in self._catalogue.list()]
        return [one for _, one in sorted(found, key=lambda pair: pair[0], reverse=True)]

    def ids(self) -> set[str]:
        """Of all that is in it; far quicker than what it is."""
        try:
            names = {file.stem for file in self._bin.iterdir() if file.suffix in (".json", ".rrd")}
        except OSError:
            return set()
        return {name for name in names if sidecar.is_id(name)}

    def put(self, id: str) -> None:
        """Move a recording in; OSError where the folder takes no change."""
        self._bin.mkdir(sidecar.FOLDER_MODE, exist_ok=True)
        self._count_from_now(id)
        self._move(id, self._folder, self._bin, (f"{id}.json", f"{id}.rrd"))

    def take_back(self, id: str) -> None:
        """Move it out again; RecordingError where it is not here, CommandRefused where another has its id now."""
        sidecar.check_id(id)
        if id not in self.ids():
            raise RecordingError(f"there is no deleted recording {id!r}: it may be gone for good")
        if is_regular(self._folder / f"{id}.json") or (
            is_regular(self._folder / f"{id}.rrd") and is_regular(self._bin / f"{id}.rrd")
        ):
            raise CommandRefused(f"recording {id!r} cannot be taken back: there is another one of that id")
        self._move(id, self._bin, self._folder, (f"{id}.rrd", f"{id}.json"))

    def erase(self, id: str) -> None:
        """Remove it for good."""
        prepared.forget(self._bin / f"{id}.rrd")
        for name in (f"{id}.rrd", f"{id}.json"):
            (self._bin / name).unlink(missing_ok=True)
        sync_folder(self._bin)

    def expired(self) -> tuple[str, ...]:
        """What lies here for more than KEPT_S. To be asked now and then: time counts from one look to the next."""
        ages = read_ages(self._bin / AGES).now(self.ids())
        write_ages(self._bin / AGES, ages)
        return tuple(id for id, age in ages.ages.items() if age > KEPT_S)

    def settle(self) -> None:
        """Let the data follow where a kill came between the two renames."""
        for id in self.ids():
            left = [file for file in (self._folder / f"{id}.rrd", self._folder / f"{id}.json") if is_regular(file)]
            if [file.suffix for file in left] == [".rrd"] and not is_regular(self._bin / f"{id}.rrd"):
                self._move(id, self._folder, self._bin, (f"{id}.rrd",))

    def _count_from_now(self, id: str) -> None:
        """Forget how long it lay here before it was taken back."""
        known = read_ages(self._bin / AGES)
        if id in known.ages:
            write_ages(self._bin / AGES, known.now(set(known.ages) - {id}))

    def _move(self, id: str, source: Path, target: Path, names: tuple[str, ...]) -> None:
        """One after the other, each on the disk before the next; the quick look comes along where there is one."""
        prepared.move(source / f"{id}.rrd", target / f"{id}.rrd")
        for name in names:
            if is_regular(source / name):
                (source / name).rename(target / name)
                sync_folder(target)
                sync_folder(source)

    def _since(self, id: str) -> float:
        """When it was renamed [s since 1970]; 0 where that cannot be said."""
        for name in (f"{id}.json", f"{id}.rrd"):
            try:
                return (self._bin / name).lstat().st_ctime
            except OSError:
                continue
        return 0.0
