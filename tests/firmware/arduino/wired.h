// A board with one channel, for this machine: what the programs here try is how the library runs it.
#pragma once
#include "arduino/rig.h"

unsigned sensors_read = 0;
int pins[64];
uint32_t now = 0;

const tendril::Config CONFIG = {"here", tendril::HOLDS_PRESSURE, 0, 300000, 340000, 20000, {84, 168, 328}};
const tendril::Wiring<1> WIRING = {{{0, 103, 51, 973, 618750}}, {{2, 3, true}}, 10, 11};
