"""Commissioning: a fresh rig's first hour, step by step, each with a way back; what it finds goes into the rig file."""
