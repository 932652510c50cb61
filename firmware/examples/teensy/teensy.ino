// Teensy 4.0 or 4.1: as the Mega. Its pins take 3.3 V: sensors through a divider of 2:3.
// Sensors of 0.5 to 4.5 V over 0 to 500 kPa: 0 Pa at 103 counts, 618750 Pa per 1034 counts, broken below 51 or above 973.
#include <TendrilBoard.h>

using namespace tendril;

const Config CONFIG = {
    "Teensy 4",
    HOLDS_PRESSURE | TAKES_OPENINGS | CUTS_SUPPLY | HAS_E_STOP_INPUT,
    0,               // least setpoint [Pa]
    300000,          // largest setpoint [Pa]
    340000,          // above it: vent, cut the supply, stay stopped [Pa]
    20000,           // slew of setpoints [Pa/ms]
    {84, 168, 328},  // 1e-5 and 2e-5 per Pa, 0.2 s: see core/pressure_loop.h
};

const Wiring<4> WIRING = {
    {{A0, 103, 51, 973, 618750}, {A1, 103, 51, 973, 618750}, {A2, 103, 51, 973, 618750}, {A3, 103, 51, 973, 618750}},
    {{2, 3, true}, {4, 5, true}, {6, 7, true}, {8, 9, true}},
    10,  // supply valve
    11,  // hardware stop
};

Rig<4, decltype(Serial)> rig(CONFIG, WIRING, Serial);

void setup() { rig.begin(); }
void loop() { rig.poll(); }
