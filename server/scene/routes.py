"""A page's own 3D view: camera, ground, paths, and a recording that is played there."""

import asyncio
from functools import lru_cache
from pathlib import Path

import numpy as np
from fastapi import APIRouter

from controller.errors import CommandRefused
from recordings.read.playback import PlaybackRows, read_playback
from server.http.who import Me
from server.recorder.client import GivenRecorder
from server.recorder.folder import GivenFolder, GivenReader, Reader
from server.scene.messages import Playback, PlaybackBody, Role, SeatId, SeatLook, SeatPath
from server.scene.playback import Player
from server.scene.scene import GivenScene

router = APIRouter(tags=["scene"])


@router.put("/api/scene/{seat}/look", status_code=204)
async def change_look(seat: SeatId, body: SeatLook, scene: GivenScene, who: Me) -> None:
    """Ground and camera of this view alone."""
    scene.view_session(seat, who).look(body.scheme, body.view)


@router.put("/api/scene/{seat}/path/{role}", status_code=204)
async def change_path(seat: SeatId, role: Role, body: SeatPath, scene: GivenScene, who: Me) -> None:
    """Show a path in this view alone."""
    lines = [np.array(line) for line in body.lines]
    await asyncio.to_thread(scene.view_session(seat, who).show_path, role, lines)


@router.put("/api/scene/{seat}/playback")
async def play(
    seat: SeatId,
    body: PlaybackBody,
    scene: GivenScene,
    folder: GivenFolder,
    reader: GivenReader,
    recorder: GivenRecorder,
    who: Me,
) -> Playback:
    """Play a recording in this view alone, from a time on, or stand there; 404 without such a recording."""
    session, state = scene.view_session(seat, who), recorder.state()
    if state.recording and state.id == body.recording:
        raise CommandRefused("this recording is still written: stop it first")
    path = await folder.look(folder.store.path, body.recording)
    player = session.player
    if player is None or player.id != body.recording:
        player = Player(body.recording, await asyncio.to_thread(_playback, path, reader))
        session.play(player)
    player.control(body)
    return player.state()


@router.delete("/api/scene/{seat}/playback", status_code=204)
async def end_playback(seat: SeatId, scene: GivenScene, who: Me) -> None:
    """Show the rig as it is now again."""
    scene.view_session(seat, who).play(None)


@lru_cache(maxsize=2)
def _playback(path: Path, reader: Reader) -> PlaybackRows:
    """Those that were asked for last: several pages may play the same one."""
    return reader.call(read_playback, path)
