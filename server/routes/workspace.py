"""How far the tip reaches."""

from fastapi import APIRouter

router = APIRouter(tags=["rig"])
