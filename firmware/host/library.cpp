// The core as a library of one board, whose time is an argument: what tests step through.
#include "config.h"

using namespace tendril;

namespace {
HostBoard board(HOST_CONFIG, 1, 0);
}

extern "C" {

void start(uint16_t boot, uint32_t now) { board = HostBoard(HOST_CONFIG, boot, now); }

// Takes `count` bytes; writes the last reply to `out` (100 bytes) and returns its size, 0 where none is due.
int receive(const uint8_t* bytes, int count, uint32_t now, uint8_t* out) {
  int size = 0;
  for (int i = 0; i < count; ++i) {
    if (!board.receive(bytes[i], now)) continue;
    size = board.reply_size();
    for (int j = 0; j < size; ++j) out[j] = board.reply()[j];
  }
  return size;
}

void step(uint32_t now, const int32_t* pressures, int e_stop) {
  int32_t shown[HOST_CHANNELS];
  for (int i = 0; i < HOST_CHANNELS; ++i) shown[i] = pressures[i];
  board.step(now, shown, e_stop != 0);
}

int opening(int channel) { return board.opening(static_cast<uint8_t>(channel)); }
int setpoint(int channel) { return board.setpoint(static_cast<uint8_t>(channel)); }
int reasons() { return board.reasons(); }
int rejected() { return static_cast<int>(board.rejected()); }
int outputs() {
  const Outputs& out = board.outputs();
  return (out.vent ? VENTED : 0) | (out.cut ? SUPPLY_CUT : 0) | (out.raw ? TAKES_RAW : 0);
}
}
