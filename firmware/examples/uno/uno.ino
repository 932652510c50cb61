// Arduino Uno: four chambers, each with two on-off valves; all of its pins but D0, D1 (the host) and A4, A5.
// Sensors of 0.5 to 4.5 V over 0 to 500 kPa: 0 Pa at 102 counts, 625000 Pa per 1024 counts, broken below 51 or above 973.
#include <TendrilBoard.h>

using namespace tendril;

const Config CONFIG = {
    "Arduino Uno",
    HOLDS_PRESSURE | TAKES_OPENINGS | CUTS_SUPPLY | HAS_E_STOP_INPUT,
    0,               // least setpoint [Pa]
    300000,          // largest setpoint [Pa]
    340000,          // above it: vent, cut the supply, stay stopped [Pa]
    20000,           // slew of setpoints [Pa/ms]
    {84, 168, 328},  // 1e-5 and 2e-5 per Pa, 0.2 s: see core/pressure_loop.h
};

const Wiring<4> WIRING = {
    {{A0, 102, 51, 973, 625000}, {A1, 102, 51, 973, 625000}, {A2, 102, 51, 973, 625000}, {A3, 102, 51, 973, 625000}},
    {{2, 3, false}, {4, 5, false}, {6, 7, false}, {8, 9, false}},
    10,  // supply valve
    11,  // hardware stop
};

Rig<4, decltype(Serial)> rig(CONFIG, WIRING, Serial);

void setup() { rig.begin(); }
void loop() { rig.poll(); }
