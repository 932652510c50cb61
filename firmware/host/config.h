// The board that the host build is.
#pragma once
#include "../src/core/board.h"

namespace tendril {

constexpr uint8_t HOST_CHANNELS = 8;

const Config HOST_CONFIG = {
    "host", HOLDS_PRESSURE | TAKES_OPENINGS | CUTS_SUPPLY | HAS_E_STOP_INPUT, 0, 300000, 340000, 20000, {84, 168, 328},
};

using HostBoard = Board<HOST_CHANNELS>;

}  // namespace tendril
