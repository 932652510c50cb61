// Everything that a sketch needs: the board logic, and how an Arduino or Teensy reads sensors and moves valves.
#pragma once
#include "arduino/rig.h"
#include "core/board.h"
