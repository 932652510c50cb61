// Everything that a sketch needs: the board logic, and how an Arduino or Teensy reads sensors and moves valves.
#pragma once
#pragma GCC optimize ("O2")
#include "arduino/rig.h"
#include "core/board.h"
