"""My macros: listed, kept, deleted, run and stopped."""

import asyncio

from fastapi import APIRouter

from server.access.permit import Permitted
from server.http.who import Me
from server.operate.operator import GivenOperator
from server.runs.macros.macros import GivenMacros, Series
from server.runs.macros.messages import Macro, MacroBody, MacroName, MacroState
from server.runs.macros.store import GivenMacroStore
from server.runs.messages import LearnBody

router = APIRouter(tags=["macros"])


@router.get("/api/macros")
async def read_macros(store: GivenMacroStore, who: Me) -> list[Macro]:
    """My macros, by name."""
    return await asyncio.to_thread(store.listed, who)


@router.put("/api/macros/{name}")
async def keep_macro(name: MacroName, body: MacroBody, store: GivenMacroStore, who: Me) -> list[Macro]:
    """Keep a macro for me, in place of mine of this name; all of mine. 409 when I have too many."""
    await asyncio.to_thread(store.write, who, name, body)
    return await asyncio.to_thread(store.listed, who)


@router.delete("/api/macros/{name}")
async def delete_macro(name: MacroName, store: GivenMacroStore, who: Me) -> list[Macro]:
    """Forget one of my macros; the others."""
    await asyncio.to_thread(store.delete, who, name)
    return await asyncio.to_thread(store.listed, who)


@router.post("/api/macros/{name}/run")
async def run_macro(
    name: MacroName, store: GivenMacroStore, macros: GivenMacros, operator: GivenOperator, permit: Permitted, who: Me
) -> MacroState:
    """Do the steps of one of my macros, one after the other, while I operate; 409 while one runs, 404 without it."""
    macro = await asyncio.to_thread(store.read, who, name)
    operator.present(permit)
    return macros.start(macro, permit)


@router.post("/api/run/learn", tags=["runs"])
async def learn_path(body: LearnBody, macros: GivenMacros, operator: GivenOperator, permit: Permitted) -> MacroState:
    """Repeat a path and learn it from its errors, as a macro whose steps are the repeats; 409 while one runs."""
    operator.present(permit)
    name = body.reference if body.drawing is None else body.drawing.name
    return macros.start(Series(name or "", body.runs()), permit)


@router.post("/api/macros/stop")
async def stop_macro(macros: GivenMacros, permit: Permitted) -> MacroState:
    """End the macro, and hold what it has set in motion; 409 when none runs."""
    return macros.stop(permit)
